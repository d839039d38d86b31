"""Pictures of a house from any place, rendered without a display by MuJoCo's classic renderer.

Every part becomes a visual mesh; nothing here collides (MuJoCo would take convex hulls, which fill
rooms). MuJoCo reads the variable MUJOCO_GL on import, so it is chosen first: EGL, else OSMesa.
"""

from __future__ import annotations

import ctypes.util
import os
import weakref
from collections.abc import Callable
from functools import partial
from math import atan, degrees

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.mirror import Mirror, MirrorPixels
from sim_stubs.homes.geometry.solids import Part
from sim_stubs.world.lighting import LAMP, Lighting, lamp_weights
from sim_stubs.world.visibility import Visibility
from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.program.interrupts import is_interrupt
from vizbot.core.program.kernels import kernel
from vizbot.core.types import SE3, Intrinsics

REMEDY = "apt-get install libegl1 libgl1"
_CHOSEN = {
    name: value if value.isprintable() else ascii(value)
    for name in ("MUJOCO_GL", "PYOPENGL_PLATFORM")
    if (value := os.environ.get(name))
}
"""How somebody has other programs render, as it can be shown."""


def cannot_render(error: object = "") -> DeviceError:
    """The error where nothing can be rendered, in one line with what to do."""
    chosen = ", ".join(f"{name}={value}" for name, value in _CHOSEN.items())
    reason = f" ({' '.join(str(error).split())})" if str(error) else ""
    how = f" with {chosen}, which is set here" if chosen else ""
    remedy = f"unset {' '.join(_CHOSEN)}" if chosen else REMEDY
    return DeviceError(f"cannot render{how}{reason}; {remedy}")


def _platform() -> str:
    if ctypes.util.find_library("EGL") and ctypes.util.find_library("GL"):
        return "egl"
    if ctypes.util.find_library("OSMesa"):
        return "osmesa"
    raise cannot_render("no EGL and no OSMesa")


if "MUJOCO_GL" not in os.environ:
    os.environ["MUJOCO_GL"] = _platform()
try:
    import mujoco
except ModuleNotFoundError as missing:
    raise ConfigError(
        f"simulated worlds need {missing.name}, not installed: pip install mujoco"
    ) from missing
except (AttributeError, ImportError, RuntimeError, ctypes.ArgumentError) as missing:
    if is_interrupt(missing):
        raise KeyboardInterrupt from missing
    raise cannot_render() from missing

NEAR, FAR = 0.02, 40.0
"""Clipping planes [m]; near is closer than the mast lets any wall come to the lens."""

HIDDEN = 3
"""MuJoCo draws the geom groups 0 to 2."""


class Renderer(Closeable):
    """A renderer with the house loaded.

    A picture depends only on the house, its lighting and the pose of the camera.

    Attributes:
        intrinsics: Intrinsics of its pictures, with the principal point in the middle.
    """

    def __init__(
        self,
        house: House,
        intrinsics: Intrinsics,
        lighting: Lighting | None = None,
        *,
        cull: bool = True,
        visibility: Callable[[], Visibility] | None = None,
    ) -> None:
        """Load the house.

        Args:
            house: The house to draw.
            intrinsics: Intrinsics of the pictures.
            lighting: Lighting of the house; neutral by default.
            cull: Whether to draw only what is in sight, which gives the same pictures faster.
            visibility: Returns what the walls hide, where somebody else works it out while MuJoCo
                compiles.

        Raises:
            DeviceError: the machine has no working OpenGL.
        """
        self.intrinsics = intrinsics
        self._lamps, self._mirror = house.lights, house.mirror
        self._diffuse = (lighting or Lighting()).rgb
        self._model = _compiled(house, intrinsics, self._diffuse)
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)
        self._option = mujoco.MjvOption()
        self._scene = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 10)
        self._rect = mujoco.MjrRect(0, 0, intrinsics.width, intrinsics.height)
        try:
            self._gl = mujoco.GLContext(intrinsics.width, intrinsics.height)
            self._gl.make_current()
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except Exception as error:  # whatever PyOpenGL and the driver come up with
            if is_interrupt(error):
                raise KeyboardInterrupt from error
            raise cannot_render(error) from error
        # Left to MuJoCo, a forgotten context would free its textures in whichever one is current.
        self._free = weakref.finalize(self, _freed, self._gl, self._context)
        self._free.atexit = False  # EGL may be gone before
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._visibility: Visibility | None = None
        if cull:
            self._visibility = (visibility or partial(Visibility.in_house, house, intrinsics))()

    def render(self, T_world_cam: SE3) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colour (H, W, 3) and depth along the optical axis (H, W) [m], 0 where nothing is.

        A mirror has the colour and the depth of what it shows.
        """
        self._draw(T_world_cam)
        rgb, depth = self._read(self._rect, NEAR)
        if self._mirror is not None:
            seen = self._mirror.seen(T_world_cam, self.intrinsics, depth)
            if seen is not None and self._mirror.before(T_world_cam[:3, 3]) > NEAR:
                self._reflect(self._mirror, seen, T_world_cam, rgb, depth)
        return rgb, depth

    def segment(self, T_world_cam: SE3) -> NDArray[np.int32]:
        """Index in `House.instances` that each pixel (H, W) shows; -1 for structure."""
        rgb = np.empty((self.intrinsics.height, self.intrinsics.width, 3), np.uint8)
        flags = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
        for flag in flags:
            self._scene.flags[flag] = True
        self._draw(T_world_cam)
        mujoco.mjr_readPixels(rgb, None, self._rect, self._context)
        for flag in flags:
            self._scene.flags[flag] = False
        ids = rgb[::-1, :, 0] | rgb[::-1, :, 1].astype(np.uint16) << 8
        instance_of = np.full(self._scene.ngeom + 1, -1, np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0:
                # Body 0 is the world with the structure; bodies follow in the order of instances.
                instance_of[geom.segid + 1] = self._model.geom_bodyid[geom.objid] - 1
        return np.asarray(instance_of[ids])

    def plan(self, centre: NDArray[np.float64], extent: float) -> NDArray[np.uint8]:
        """Picture (H, W, 3) of the home from above, `extent` [m] high, north up.

        Ceilings face downwards and are not drawn from behind.
        """
        self._model.geom_group[:] = 0
        self._update(np.array([*centre, 12.0]), np.eye(3))
        ratio = self.intrinsics.width / self.intrinsics.height
        for eye in self._scene.camera:  # a pair for stereo; both count
            eye.orthographic = 1
            eye.frustum_top, eye.frustum_bottom = extent / 2, -extent / 2
            eye.frustum_center, eye.frustum_width = 0.0, extent / 2 * ratio
        mujoco.mjr_render(self._rect, self._scene, self._context)
        rgb = np.empty((self.intrinsics.height, self.intrinsics.width, 3), np.uint8)
        mujoco.mjr_readPixels(rgb, None, self._rect, self._context)
        return np.ascontiguousarray(rgb[::-1])

    def close(self) -> None:
        """Free the OpenGL context."""
        self._free()

    def _read(
        self, rect: mujoco.MjrRect, near: float
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colour and depth [m] of what is drawn in `rect`, with the near clipping plane there."""
        shape = (rect.height, rect.width)
        rgb, depth = np.empty((*shape, 3), np.uint8), np.empty(shape, np.float32)
        mujoco.mjr_readPixels(rgb, depth, rect, self._context)
        metres = np.empty_like(depth)
        _to_metres(
            depth[::-1], np.float32(near * FAR), np.float32(near), np.float32(FAR - near), metres
        )
        return np.ascontiguousarray(rgb[::-1]), metres

    def _reflect(
        self,
        mirror: Mirror,
        seen: MirrorPixels,
        T_world_cam: SE3,
        rgb: NDArray[np.uint8],
        depth: NDArray[np.float32],
    ) -> None:
        """Write what the mirror shows into a picture, at the pixels where it is seen.

        The eye behind the mirror looks straight through it, with the mirror as its near clipping
        plane, so that nothing behind the mirror is in the way (Kooima 2009, "Generalized
        perspective projection").
        """
        eye, normal, before = T_world_cam[:3, 3], mirror.normal, mirror.before(T_world_cam[:3, 3])
        if self._visibility is not None:
            shown = self._visibility.in_view(mirror.reflected(T_world_cam))
            self._model.geom_group[:] = np.where(shown, 0, HIDDEN)
        width, height = np.linalg.norm(mirror.along), np.linalg.norm(mirror.up)
        # OpenGL cameras look along -z with y up: from behind, the mirror's left is on the right.
        axes = np.column_stack([-mirror.along / width, mirror.up / height, -normal])
        behind = eye - 2 * before * normal
        self._update(behind, axes, lit_around=eye)
        x, y, _ = (mirror.corner - behind) @ axes
        s, t = seen.s[seen.shown], seen.t[seen.shown]
        left, right = x - width * s.max(), x - width * s.min()
        bottom, top = y + height * t.min(), y + height * t.max()
        for each in self._scene.camera:  # a pair for stereo; both count
            each.frustum_near = before
            each.frustum_center, each.frustum_width = (left + right) / 2, (right - left) / 2
            each.frustum_bottom, each.frustum_top = bottom, top
        rows, columns = seen.shown.shape
        rect = mujoco.MjrRect(0, 0, columns, rows)
        mujoco.mjr_render(rect, self._scene, self._context)
        at = (
            ((x - width * seen.s - left) / (right - left) * columns - 0.5).astype(np.float32),
            ((top - y - height * seen.t) / (top - bottom) * rows - 0.5).astype(np.float32),
        )
        colours, depths = self._read(rect, before)
        colours = cv2.remap(colours, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        depths = cv2.remap(depths, *at, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
        rgb[seen.window][seen.shown] = colours[seen.shown]
        # Along a ray depth grows as the distance from the plane does.
        depth[seen.window][seen.shown] = (seen.glass * (depths / before))[seen.shown]

    def _draw(self, T_world_cam: SE3) -> None:
        if self._visibility is not None:
            seen = self._visibility.seen(T_world_cam)
            self._model.geom_group[:] = np.where(seen, 0, HIDDEN)
        # OpenGL cameras look along -z with y up.
        self._update(T_world_cam[:3, 3], T_world_cam[:3, :3] @ np.diag([1.0, -1.0, -1.0]))
        mujoco.mjr_render(self._rect, self._scene, self._context)

    def _update(
        self,
        position: NDArray[np.float64],
        rotation: NDArray[np.float64],
        lit_around: NDArray[np.float64] | None = None,
    ) -> None:
        """Take the scene from a place, with the lamps lit that are near it, or another one."""
        if not self._free.alive:
            raise DeviceError("the simulated world is closed; open it again")
        self._gl.make_current()
        self._data.cam_xpos[0] = position
        self._data.cam_xmat[0] = rotation.ravel()
        weights = lamp_weights(self._lamps, position if lit_around is None else lit_around)
        self._model.light_diffuse[:] = LAMP * self._diffuse * weights[:, None]
        self._model.light_active[:] = weights > 0
        camera = mujoco.MjvCamera()
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )


@kernel("void(f4[:,:], f4, f4, f4, f4[:,::1])", error_model="numpy")
def _to_metres(
    buffer: NDArray[np.float32],
    product: np.float32,
    near: np.float32,
    span: np.float32,
    metres: NDArray[np.float32],
) -> None:
    """Write the depth [m] that a reversed depth buffer means: 1 is `near`, 0 is FAR or nothing.

    Args:
        buffer: (H, W) as the renderer gives it.
        product: Product of both clipping distances.
        near: The near one [m].
        span: What they differ by [m].
        metres: (H, W) depth, written here.
    """
    for row in range(buffer.shape[0]):
        for column in range(buffer.shape[1]):
            z = buffer[row, column]
            far_away = product / (near + z * span)
            metres[row, column] = far_away if z > np.float32(0.0) else np.float32(0.0)


def _freed(gl: mujoco.GLContext, context: mujoco.MjrContext) -> None:
    gl.make_current()
    context.free()
    gl.free()


def _compiled(house: House, intrinsics: Intrinsics, tint: NDArray[np.float64]) -> mujoco.MjModel:
    """The house as a MuJoCo model: one body for each instance, in order, named as it is."""
    spec = mujoco.MjSpec()
    spec.stat.extent = 1.0
    spec.visual.map.znear, spec.visual.map.zfar = NEAR, FAR
    spec.visual.quality.offsamples = 0
    spec.visual.quality.shadowsize = 0  # none are drawn
    spec.visual.global_.offwidth = intrinsics.width
    spec.visual.global_.offheight = intrinsics.height
    spec.visual.headlight.ambient = 0.38 * tint
    spec.visual.headlight.diffuse = 0.12 * tint
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    fovy = degrees(2 * atan(intrinsics.height / 2 / intrinsics.fy))
    spec.worldbody.add_camera(name="eye", fovy=fovy)
    for light in house.lights:
        spec.worldbody.add_light(
            # The classic renderer has no point lights; a spot that opens all the way is one.
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            cutoff=180.0,
            exponent=0.0,
            pos=light,
            castshadow=False,
            ambient=[0.0, 0.0, 0.0],
            specular=[0.05, 0.05, 0.05],
            attenuation=[0.75, 0.05, 0.12],
        )
    meshes = _Meshes(spec)
    for part in house.structure:
        meshes.add_geom(spec.worldbody, part)
    for instance in house.instances:
        T = instance.T_world_piece
        quat = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
        body = spec.worldbody.add_body(name=instance.name, pos=T[:3, 3], quat=quat)
        for part in instance.piece.parts:
            meshes.add_geom(body, part)
    return spec.compile()


class _Meshes:
    """Meshes, textures and materials of a model under construction, each stored once."""

    def __init__(self, spec: mujoco.MjSpec) -> None:
        self._spec = spec
        self._names: dict[int, tuple[str, str]] = {}
        self._textures: dict[str, str] = {}

    def add_geom(self, body: mujoco.MjsBody, part: Part) -> None:
        if id(part) not in self._names:
            self._names[id(part)] = (self._mesh(part), self._material(part))
        mesh, material = self._names[id(part)]
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=mesh,
            material=material,
            contype=0,
            conaffinity=0,
        )

    def _mesh(self, part: Part) -> str:
        name = f"mesh {len(self._names)}"
        mesh = self._spec.add_mesh(name=name)
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        mesh.uservert, mesh.userface = part.vertices.ravel(), part.faces.ravel()
        mesh.usernormal, mesh.userfacenormal = part.normals.ravel(), part.faces.ravel()
        if part.texture is not None:
            mesh.usertexcoord = part.texcoords.ravel()
            mesh.userfacetexcoord = part.faces.ravel()
        return name

    def _material(self, part: Part) -> str:
        name = f"material {len(self._names)}"
        material = self._spec.add_material(name=name, rgba=part.rgba)
        material.specular, material.shininess = 0.2, 0.3
        if part.texture is not None:
            texture = str(part.texture)
            if texture not in self._textures:
                self._textures[texture] = f"texture {len(self._textures)}"
                self._spec.add_texture(
                    name=self._textures[texture],
                    type=mujoco.mjtTexture.mjTEXTURE_2D,
                    file=texture,
                )
            material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = self._textures[texture]
        return name
