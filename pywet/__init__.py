"""Screening of moist particles in LIGGGHTS, with force laws in Python and an independent reference that checks them."""


def __getattr__(name: str) -> str:
    """`__version__`, that of the installed package; asked for late, so that importing costs nothing."""
    if name != "__version__":
        raise AttributeError(f"module {__name__} has no attribute {name}")
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("pywet")
    except PackageNotFoundError:
        return "not installed as a package"
