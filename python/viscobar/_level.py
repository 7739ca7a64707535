"""The folder of the compiled module: one for each level of x86-64 that the package was built for."""
import os
import platform

_LEVELS = ("x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4")
_NEEDS = ({"sse4_2", "popcnt"}, {"avx2", "fma", "bmi2"}, {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"})


def _usable() -> int:
    """What the processor has, or less where VISCOBAR_LEVEL asks for that."""
    with open("/proc/cpuinfo") as text:
        flags = set(next((line for line in text if line.startswith("flags")), "").split())
    level = next((k for k, needed in enumerate(_NEEDS) if not needed <= flags), len(_NEEDS))
    asked = os.environ.get("VISCOBAR_LEVEL", "")
    return min(level, _LEVELS.index(asked)) if asked in _LEVELS else level


def folder(package: str) -> str:
    """The highest level of the package that this processor has. Raises ImportError where there is none."""
    usable = reversed(_LEVELS[:_usable() + 1]) if platform.machine() in ("x86_64", "AMD64") else [platform.machine()]
    for name in ("native", *usable):
        if os.path.isdir(os.path.join(package, name)):
            return os.path.join(package, name)
    built = [name for name in _LEVELS if os.path.isdir(os.path.join(package, name))]
    raise ImportError(f"viscobar was built for processors of the level {built[0]}, which this one has not: build it here, or with "
                      "-DVISCOBAR_LEVEL=x86-64 for all" if built else "viscobar has no compiled module: it was not built")
