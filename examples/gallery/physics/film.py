"""Draws a recorded run: the path from above, and a film with the controller's states and reasons.

python3 -m physics.film run.json path.png film.gif
"""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from physics.worlds import WORLDS

WIDTH, HEIGHT, PANEL = 320, 240, 250
FRAME = 100
"""Milliseconds. Poses are recorded every 200, so the film is twice as fast as the robot."""
COLOURS = 64
LETTERS = 36
"""In a line of the panel."""
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", type=Path)
    parser.add_argument("path", type=Path)
    parser.add_argument("film", type=Path)
    args = parser.parse_args()
    run = json.loads(args.run.read_text(encoding="utf-8"))
    world = WORLDS[run["world"]](run["seed"])
    stage = Stage(world, run["poses"])
    stage.path(run["path"]).save(args.path)
    pictures = [
        with_panel(picture, time, state)
        for picture, (time, state) in zip(stage.pictures(), run["states"], strict=True)
    ]
    palette = palette_of(pictures)
    frames = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    frames[0].save(
        args.film, save_all=True, append_images=frames[1:], duration=FRAME, loop=0, optimize=True
    )
    stage.close()
    world.close()


def palette_of(pictures: list[Image.Image]) -> Image.Image:
    """Return a picture with the colours of the film, also of what is small: the same in all frames,
    or the floor would flicker."""
    some = pictures[:: max(1, len(pictures) // 8)]
    sheet = Image.new("RGB", (WIDTH + PANEL, HEIGHT * len(some)))
    for number, picture in enumerate(some):
        sheet.paste(picture, (0, HEIGHT * number))
    return sheet.quantize(COLOURS, Image.Quantize.MAXCOVERAGE)


class Stage:
    """A world as it was in a run."""

    def __init__(self, world: Any, poses: list[list[float]]) -> None:
        self._world, self._poses = world, poses
        self._renderer = mujoco.Renderer(world.model, HEIGHT, WIDTH)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._camera = mujoco.MjvCamera()
        self._camera.lookat[:] = world.view.get("lookat", (0.0, 0.0, 0.0))

    def _picture(self, elevation: float, azimuth: float) -> Image.Image:
        self._camera.distance = self._world.view["distance"]
        self._camera.elevation, self._camera.azimuth = elevation, azimuth
        self._renderer.update_scene(self._world.data, camera=self._camera)
        return Image.fromarray(self._renderer.render())

    def _pose(self, pose: list[float]) -> None:
        self._world.data.qpos[:] = np.array(pose)
        mujoco.mj_forward(self._world.model, self._world.data)

    def pictures(self) -> Iterator[Image.Image]:
        """Yield a picture of each pose."""
        for pose in self._poses:
            self._pose(pose)
            yield self._picture(self._world.view["elevation"], self._world.view["azimuth"])

    def path(self, places: list[list[float]]) -> Image.Image:
        """Return the last pose from above, with the way to it. Seen from straight above, the floor
        is to scale."""
        self._pose(self._poses[-1])
        picture = self._picture(-90.0, 90.0)
        fovy = math.radians(float(self._world.model.vis.global_.fovy))
        scale = HEIGHT / (2 * self._world.view["distance"] * math.tan(fovy / 2))
        x, y, _ = self._camera.lookat
        points = [
            (WIDTH / 2 + (px - x) * scale, HEIGHT / 2 - (py - y) * scale) for px, py in places
        ]
        ImageDraw.Draw(picture).line(points, fill=(220, 40, 40), width=2)
        return picture

    def close(self) -> None:
        self._renderer.close()


def with_panel(picture: Image.Image, time: float, state: dict[str, Any]) -> Image.Image:
    """Return a picture with what the controller says of itself at its side."""
    whole = Image.new("RGB", (WIDTH + PANEL, HEIGHT), (250, 250, 250))
    whole.paste(picture, (0, 0))
    draw = ImageDraw.Draw(whole)
    y = 6
    for text, colour in lines(time, state):
        draw.text((WIDTH + 8, y), text, fill=colour, font=ImageFont.truetype(FONT, 10))
        y += 13
    return whole


def lines(time: float, state: dict[str, Any]) -> Iterator[tuple[str, tuple[int, int, int]]]:
    """Yield the lines of the panel with their colours."""
    black, green, grey = (20, 20, 20), (0, 120, 40), (130, 130, 130)
    yield f"{time:.1f} s", grey
    for name, value in state.get("components", {}).items():
        yield f"{name}: {value}", black
    for name, phase in state.get("communications", {}).items():
        yield f"{name}: {phase}", grey
    for command in state.get("commands", []):
        kind, name = command["event"]["kind"], command["event"]["name"]
        if kind == "cancel":
            if not command["enabled"]:
                continue  # as always but just before it is sent
            name = f"cancel {name}"
        if command["enabled"]:
            yield f"{name}: enabled", green
        else:
            yield f"{name}: not enabled", (180, 30, 30)
            for reason in command["blocked_by"]:
                for part in textwrap.wrap(reason["text"], LETTERS)[:2]:
                    yield f"    {part}", grey


if __name__ == "__main__":
    main()
