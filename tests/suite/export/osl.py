"""Compiles shaders of Open Shading Language with the compiler in Blender's Python package, and runs some.

    osl.py FOLDER

Every .osl file of the folder is compiled. Those whose names begin with `run-` are then run at one pixel by Cycles, and
what they print goes to a .txt file of the same name. Exits with 1 if a shader is refused. Needs the package bpy.
"""

import os
import pathlib
import sys
import types

import bpy

# A part of the package above.
import _cycles  # isort: skip


class NoParameters:
    """What the Blender's add-on asks about a shader. Nothing here connects its parameters."""

    def __init__(self, _path):
        self.parameters = []


def empty_scene():
    """A plane that gives off what a shader computes, seen at one pixel. Returns its nodes."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.cycles.device, scene.cycles.shading_system = "CPU", True
    scene.cycles.samples, scene.cycles.max_bounces = 1, 0
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    bpy.ops.mesh.primitive_plane_add(size=10)
    plane = bpy.context.object
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0, 0, 3)
    scene.collection.objects.link(camera)
    scene.camera = camera
    material = bpy.data.materials.new("shader")
    material.use_nodes = True
    plane.data.materials.append(material)
    tree = material.node_tree
    tree.nodes.clear()
    output, emission = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], output.inputs[0])
    return tree, emission


def run(path, tree, emission):
    """Renders with a shader. What it prints goes to a file."""
    node = tree.nodes.new("ShaderNodeScript")
    node.mode, node.filepath = "EXTERNAL", str(path)
    node.outputs.new("NodeSocketColor", "colour")
    tree.links.new(node.outputs[0], emission.inputs[0])
    sys.stdout.flush()
    terminal = os.dup(1)
    with open(path.with_suffix(".txt"), "w") as printed:
        os.dup2(printed.fileno(), 1)
        try:
            bpy.ops.render.render()
        finally:
            os.dup2(terminal, 1)
            os.close(terminal)
    tree.nodes.remove(node)


def main(folder):
    sys.modules["oslquery"] = types.SimpleNamespace(OSLQuery=NoParameters)
    paths = sorted(folder.glob("*.osl"))
    refused = [path for path in paths if not _cycles.osl_compile(str(path), str(path.with_suffix(".oso")))]
    for path in refused:
        print(f"refused: {path.name}")
    runnable = [path for path in paths if path.name.startswith("run-") and path not in refused]
    if runnable:
        tree, emission = empty_scene()
        for path in runnable:
            run(path, tree, emission)
    return 1 if refused else 0


if __name__ == "__main__":
    # Blender's own shutdown reports errors of no interest.
    status = main(pathlib.Path(sys.argv[1]))
    sys.stdout.flush()
    os._exit(status)
