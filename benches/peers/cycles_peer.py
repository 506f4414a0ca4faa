"""Renders a job with Blender's Cycles: instances of one smooth ico-sphere of glass, the most bounces it allows.

Cycles' own point clouds are no choice: a ray inside a sphere of a point cloud does not find its far side."""

import os
import tempfile
import time

import bpy
import numpy as np
import OpenEXR
from mathutils import Matrix, Vector

import common

MOST_BOUNCES = 1024  # the upper limit of Blender's property


def to_z_up(points):
    """From y up to z up."""
    points = np.asarray(points, dtype=np.float64)
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def ice(ior):
    material = bpy.data.materials.new("ice")
    nodes = material.node_tree.nodes
    nodes.clear()
    glass = nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Color"].default_value = (1, 1, 1, 1)
    glass.inputs["Roughness"].default_value = 0.0
    glass.inputs["IOR"].default_value = ior
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(glass.outputs["BSDF"], output.inputs["Surface"])
    return material


def black():
    material = bpy.data.materials.new("black")
    nodes = material.node_tree.nodes
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 0.0
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    return material


def add_sky(scene):
    """Radiance 1 above the horizon, 0 below."""
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.cycles.sampling_method = "NONE"
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    place = nodes.new("ShaderNodeTexCoord")
    split = nodes.new("ShaderNodeSeparateXYZ")
    above = nodes.new("ShaderNodeMath")
    above.operation = "GREATER_THAN"
    above.inputs[1].default_value = 0.0
    background = nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(place.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["Z"], above.inputs[0])
    links.new(above.outputs[0], background.inputs["Color"])
    links.new(background.outputs[0], output.inputs["Surface"])


def add_grains(scene, centres, radii, ior, subdivisions):
    """One mesh of points; geometry nodes put a sphere on each."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=1.0)
    ball = bpy.context.object
    for polygon in ball.data.polygons:
        polygon.use_smooth = True
    ball.data.materials.append(ice(ior))
    ball.hide_render = True
    points = bpy.data.meshes.new("points")
    points.vertices.add(len(centres))
    points.vertices.foreach_set("co", to_z_up(centres).astype(np.float32).ravel())
    size = points.attributes.new("grain_radius", "FLOAT", "POINT")
    size.data.foreach_set("value", radii.astype(np.float32))
    grains = bpy.data.objects.new("grains", points)
    scene.collection.objects.link(grains)
    tree = bpy.data.node_groups.new("grains", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links
    entry, leave = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    of_ball = nodes.new("GeometryNodeObjectInfo")
    of_ball.inputs["Object"].default_value = ball
    of_ball.inputs["As Instance"].default_value = True
    radius = nodes.new("GeometryNodeInputNamedAttribute")
    radius.data_type = "FLOAT"
    radius.inputs["Name"].default_value = "grain_radius"
    put = nodes.new("GeometryNodeInstanceOnPoints")
    links.new(entry.outputs[0], put.inputs["Points"])
    links.new(of_ball.outputs["Geometry"], put.inputs["Instance"])
    links.new(next(o for o in radius.outputs if o.enabled), put.inputs["Scale"])
    links.new(put.outputs["Instances"], leave.inputs[0])
    grains.modifiers.new("grains", "NODES").node_group = tree


def add_ground(scene, height):
    bpy.ops.mesh.primitive_plane_add(size=2e4, location=(0, 0, height))
    bpy.context.object.data.materials.append(black())


def add_camera(scene, job, shift):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle = np.deg2rad(job["fov"])
    data.clip_start, data.clip_end = 0.01, 1e6
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    origin = Vector(to_z_up(np.array(job["from"]) - shift))
    forward = (Vector(to_z_up(np.array(job["at"]) - shift)) - origin).normalized()
    right = forward.cross(Vector((0, 0, 1))).normalized()
    up = right.cross(forward)
    turn = Matrix((right, up, -forward)).transposed().to_4x4()
    camera.matrix_world = Matrix.Translation(origin) @ turn
    scene.camera = camera


def new_scene(job, centres, radii, shift):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.threads_mode = "FIXED"
    scene.render.threads = job["threads"]
    scene.render.use_persistent_data = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.transparent_max_bounces = MOST_BOUNCES
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = MOST_BOUNCES
    cycles.min_light_bounces = cycles.min_transparent_bounces = MOST_BOUNCES  # no roulette before
    add_sky(scene)
    add_grains(scene, centres - shift, radii, job["ior"], job["subdivisions"])
    if job["ground"]:
        add_ground(scene, -shift[1])
    add_camera(scene, job, shift)
    return scene


def render(scene, samples, seed):
    """Picture and the CPU and wall seconds that it took."""
    scene.cycles.samples = samples
    scene.cycles.seed = seed
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        start, start_wall = common.cpu_seconds(), time.monotonic()
        bpy.ops.render.render(write_still=True)
        spent, waited = common.cpu_seconds() - start, time.monotonic() - start_wall
        with OpenEXR.File(scene.render.filepath, separate_channels=True) as file:
            red = next(c for name, c in file.channels().items() if name.split(".")[-1] == "R")
            return np.array(red.pixels), spent, waited


def main():
    job = common.read_job()
    centres, radii = common.read_grains(job["grains"])
    shift = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    render(new_scene(job, centres[:1], radii[:1], shift), 1, 0)
    empty = common.status_bytes("VmRSS")

    start = common.cpu_seconds()
    scene = new_scene(job, centres, radii, shift)
    made = common.cpu_seconds() - start
    # The first render also builds everything; each later one repeats some of it. Renders of one sample and
    # of more tell the time of a sample from the time that is spent per render.
    _, first, _ = render(scene, 1, 999)
    _, single, single_wall = render(scene, 1, 998)
    batches, spent, waited = [], 0.0, 0.0
    more = job["samples_per_batch"]
    for batch in range(job["batches"]):
        picture, cpu, wall = render(scene, more, 1000 + batch)
        batches.append(picture)
        spent += cpu
        waited += wall
    k = job["batches"]
    of_samples = max(spent - k * single, 0.0) * more / max(more - 1, 1)
    of_samples_wall = max(waited - k * single_wall, 0.0) * more / max(more - 1, 1)
    common.answer(
        job,
        batches,
        version=bpy.app.version_string,
        variant=f"instanced ico-spheres, {job['subdivisions']} subdivisions",
        load_cpu_seconds=made + max(first - of_samples / (k * more), 0.0),
        render_cpu_seconds=of_samples,
        render_seconds=of_samples_wall,
        every_render_cpu_seconds=spent,
        empty_bytes=empty,
        peak_bytes=common.status_bytes("VmHWM"),
        path_cap=scene.cycles.max_bounces,
    )


main()
