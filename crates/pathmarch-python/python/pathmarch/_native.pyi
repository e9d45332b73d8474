import os
from typing import Any, Callable, Dict, Iterable, Literal, Optional, Sequence, Tuple, TypedDict, Union, final, overload

import numpy as np
import numpy.typing as npt

from ._types import Diagnostic, Parameter

__all__ = ["__version__", "Scene", "render", "tonemap", "encode", "save", "load", "devices", "registry"]
__version__: str

_Path = Union[str, "os.PathLike[str]"]
_Floats = npt.NDArray[np.float32]
_Layer = Literal["albedo", "normal", "depth", "position", "objectId", "materialId", "sampleCount"]
_Layers = Union[Literal["all"], _Layer, Sequence[_Layer]]
_Progress = Callable[[float, float], Any]
_Curve = Literal["agx", "neutral", "srgb"]

class _Mesh(TypedDict):
    positions: _Floats
    normals: _Floats
    colours: _Floats
    triangles: npt.NDArray[np.uint32]

@final
class Scene:
    def __new__(
        cls, source: _Path, *, time: float = 0.0, folder: Optional[_Path] = None, allow_files: bool = False
    ) -> Scene: ...
    @property
    def text(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def time(self) -> float: ...
    @property
    def animated(self) -> bool: ...
    @property
    def parameters(self) -> Tuple[Parameter, ...]: ...
    @property
    def cameras(self) -> Tuple[str, ...]: ...
    @property
    def materials(self) -> Tuple[str, ...]: ...
    @property
    def objects(self) -> Tuple[str, ...]: ...
    @property
    def bounds(self) -> _Floats: ...
    @property
    def warnings(self) -> Tuple[Diagnostic, ...]: ...
    def with_params(self, **values: Union[float, str]) -> Scene: ...
    def at(self, time: float) -> Scene: ...
    @overload
    def render(
        self,
        size: Optional[Sequence[int]] = None,
        samples: Optional[int] = None,
        seed: int = 0,
        backend: Literal["auto", "cpu", "gpu"] = "auto",
        camera: Optional[str] = None,
        time: Optional[float] = None,
        params: Optional[Dict[str, Union[float, str]]] = None,
        layers: Tuple[()] = (),
        progress: Optional[_Progress] = None,
        *,
        denoise: Optional[Literal["regression", "oidn"]] = None,
        mode: str = "path",
        adapter: Optional[str] = None,
        **settings: Any,
    ) -> _Floats: ...
    @overload
    def render(
        self,
        size: Optional[Sequence[int]] = None,
        samples: Optional[int] = None,
        seed: int = 0,
        backend: Literal["auto", "cpu", "gpu"] = "auto",
        camera: Optional[str] = None,
        time: Optional[float] = None,
        params: Optional[Dict[str, Union[float, str]]] = None,
        *,
        layers: _Layers,
        progress: Optional[_Progress] = None,
        denoise: Optional[Literal["regression", "oidn"]] = None,
        mode: str = "path",
        adapter: Optional[str] = None,
        **settings: Any,
    ) -> Dict[str, npt.NDArray[Any]]: ...
    def distance(self, points: npt.ArrayLike) -> _Floats: ...
    def gradient(self, points: npt.ArrayLike) -> _Floats: ...
    def mesh(
        self,
        resolution: int = 128,
        *,
        cell: Optional[float] = None,
        objects: Optional[Sequence[str]] = None,
        bounds: Optional[npt.ArrayLike] = None,
        progress: Optional[_Progress] = None,
    ) -> _Mesh: ...
    def export(
        self,
        path: _Path,
        resolution: int = 128,
        *,
        cell: Optional[float] = None,
        objects: Optional[Sequence[str]] = None,
        bounds: Optional[npt.ArrayLike] = None,
        unit: Optional[Literal["mm", "cm", "m", "inch"]] = None,
        progress: Optional[_Progress] = None,
    ) -> int: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...

@overload
def render(
    scene: Union[_Path, Scene],
    size: Optional[Sequence[int]] = None,
    samples: Optional[int] = None,
    seed: int = 0,
    backend: Literal["auto", "cpu", "gpu"] = "auto",
    camera: Optional[str] = None,
    time: Optional[float] = None,
    params: Optional[Dict[str, Union[float, str]]] = None,
    layers: Tuple[()] = (),
    progress: Optional[_Progress] = None,
    *,
    denoise: Optional[Literal["regression", "oidn"]] = None,
    mode: str = "path",
    adapter: Optional[str] = None,
    folder: Optional[_Path] = None,
    allow_files: bool = False,
    **settings: Any,
) -> _Floats: ...
@overload
def render(
    scene: Union[_Path, Scene],
    size: Optional[Sequence[int]] = None,
    samples: Optional[int] = None,
    seed: int = 0,
    backend: Literal["auto", "cpu", "gpu"] = "auto",
    camera: Optional[str] = None,
    time: Optional[float] = None,
    params: Optional[Dict[str, Union[float, str]]] = None,
    *,
    layers: _Layers,
    progress: Optional[_Progress] = None,
    denoise: Optional[Literal["regression", "oidn"]] = None,
    mode: str = "path",
    adapter: Optional[str] = None,
    folder: Optional[_Path] = None,
    allow_files: bool = False,
    **settings: Any,
) -> Dict[str, npt.NDArray[Any]]: ...
def tonemap(picture: npt.ArrayLike, curve: _Curve = "agx", exposure: float = 0.0) -> npt.NDArray[np.uint8]: ...
def encode(
    picture: npt.ArrayLike, format: Literal["png", "jpg", "exr"] = "png", curve: _Curve = "agx", exposure: float = 0.0
) -> bytes: ...
def save(path: _Path, picture: npt.ArrayLike, curve: _Curve = "agx", exposure: float = 0.0) -> None: ...
def load(path: _Path) -> _Floats: ...
def devices() -> list[str]: ...
def registry() -> str: ...
