"""Which form of an algorithm runs: the compiled one, or its NumPy twin, which is its specification."""

from calibore.errors import UsageError

DEFAULT_KERNEL = "native"
KERNELS = ("native", "numpy")


def is_native(kernel: str, *, known: tuple[str, ...] = KERNELS) -> bool:
    """Whether the compiled form is asked for; raises UsageError where `kernel` is none of those `known`."""
    if kernel not in known:
        *others, last = (f'"{name}"' for name in known)
        raise UsageError(f'Kernel "{kernel}" is not known; choose {", ".join(others)} or {last}.')
    return kernel != "numpy"
