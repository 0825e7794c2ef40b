"""TEMPORARY until rigs has moved()."""

from dataclasses import replace


def moved(rig, changes):
    def part(thing, table, names):
        return {n: getattr(thing, n) + changes[f"{table}.{n}"] for n in names if f"{table}.{n}" in changes}

    camera = rig.camera
    lens = replace(camera.lens, **part(camera.lens, "camera", ("k", "c1", "c2")))
    u, v = camera.principal_point
    centre = u + changes.get("camera.principal_point_u", 0.0), v + changes.get("camera.principal_point_v", 0.0)
    camera = replace(camera, lens=lens, principal_point=centre, **part(camera, "camera", ("aspect",)))
    lasers = tuple(
        replace(l, surface=replace(l.surface, **part(l.surface, rig.laser_table(i), l.surface.parameter_names)))
        for i, l in enumerate(rig.lasers)
    )
    mount = replace(rig.mount, **part(rig.mount, "laser", rig.mount.parameter_names))
    return replace(rig, camera=camera, lasers=lasers, mount=mount)
