"""An RTSP server (the package rtsp-rs) in a process of its own: `python rtsp_server.py PORT FILM ... [--rate R]`.

Sends the packets of H.264 films as they are, one after the other, from the first when somebody looks, `--loops` times.
`--silent-after N SECONDS` stutters once. Prints "ready" when it listens, then number and time of every picture sent.
`calibore live` and any player can look at rtsp://127.0.0.1:PORT/stream.
"""

import argparse
import time

import av
import rtsp

CLOCK = 90_000
"""RTP ticks a second."""


def packets(film: str) -> list[bytes]:
    """The pictures of the film as an elementary stream, parameter sets before every key frame."""
    found = []
    with av.open(film) as container:
        stream = container.streams.video[0]
        units = av.bitstream.BitStreamFilterContext("h264_mp4toannexb", stream)
        for packet in container.demux(stream):
            if packet.size:
                found += [bytes(one) for one in units.filter(packet)]
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("port", type=int)
    parser.add_argument("films", nargs="+")
    parser.add_argument("--rate", type=float, default=25.0)
    parser.add_argument("--loops", type=int, default=1)
    parser.add_argument("--silent-after", type=float, nargs=2, default=(-1, 0))
    arguments = parser.parse_args()
    server = rtsp.Server(f"127.0.0.1:{arguments.port}")
    server.start()
    print("ready", flush=True)
    while not server.get_viewers():
        time.sleep(0.01)
    send(server, [one for film in arguments.films for one in packets(film)] * arguments.loops, arguments)
    while server.get_viewers():
        time.sleep(0.02)


def send(server: rtsp.Server, film: list[bytes], arguments: argparse.Namespace) -> None:
    """The pictures in time, as a camera does."""
    start, late = time.monotonic(), 0.0
    for number, picture in enumerate(film):
        if number == int(arguments.silent_after[0]):
            time.sleep(arguments.silent_after[1])
            late += arguments.silent_after[1]
        time.sleep(max(0.0, start + late + number / arguments.rate - time.monotonic()))
        server.send_frame(picture, round(CLOCK / arguments.rate))
        print(number, time.time(), flush=True)


if __name__ == "__main__":
    main()
