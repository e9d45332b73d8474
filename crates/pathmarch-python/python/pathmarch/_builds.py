"""The build of `pathmarch._native` for the best instructions that this processor has.

A wheel may have several, in `_builds/NAME/`; the one beside this file runs everywhere. `PATHMARCH_INSTRUCTIONS=baseline`
chooses that one.
"""

import importlib
import importlib.util
import os
import sys
from pathlib import Path

# What a build needs of the processor, in the words of NumPy, from the best.
_NEEDS = {"x86-64-v3": ("AVX2", "FMA3")}


def _features():
    # NumPy 2 and NumPy 1; both are private, and have no types.
    for name in ("numpy._core._multiarray_umath", "numpy.core._multiarray_umath"):
        try:
            return importlib.import_module(name).__cpu_features__
        except (ImportError, AttributeError):
            continue
    return {}


def _best(folder):
    """The file of the best build under a folder that this processor can run, or `None`."""
    if os.environ.get("PATHMARCH_INSTRUCTIONS") == "baseline":
        return None
    features = _features()
    for name, needs in _NEEDS.items():
        files = sorted((folder / name).glob("_native*"))
        if files and all(features.get(need) for need in needs):
            return files[0]
    return None


def load():
    """Loads the best build as `pathmarch._native`, unless that is the one beside this file."""
    file = _best(Path(__file__).parent / "_builds")
    if file is None:
        return
    name = "pathmarch._native"
    spec = importlib.util.spec_from_file_location(name, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules[name] = sys.modules[__package__]._native = module
