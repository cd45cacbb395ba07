"""Meshes: PLY, OBJ and glTF by meshio, trimesh and pygltflib; Triangle's format by numpy."""

import meshio
import numpy
import pygltflib
import trimesh
from common import near, same, tool


def export(tiles, path, *options):
    """Exports a mesh, and returns the numbers of its triangles and edges."""
    report = tool("export", tiles, "-o", path, *options)
    return report["triangles"], report["edges"]


def load(path):
    return trimesh.load(path, process=False, maintain_order=True, force="mesh")


def check_ply_and_obj(folder, tiles, positions, options):
    """Returns the triangles by PLY, which the other formats must have too."""
    path = folder / "mesh.ply"
    triangles, _ = export(tiles, path, *options)
    by_meshio, by_trimesh = meshio.read(path), load(path)
    faces = by_meshio.cells_dict["triangle"]
    same("ply: triangles by meshio", len(faces), triangles)
    near("ply: vertices by meshio", by_meshio.points, positions, 0)
    near("ply: triangles by trimesh", by_trimesh.faces, faces, 0)
    near("ply: vertices by trimesh", by_trimesh.vertices, positions, 0)
    path = folder / "mesh.obj"
    export(tiles, path, *options)
    mesh = load(path)
    near("obj: triangles by trimesh", mesh.faces, faces, 0)
    near("obj: vertices by trimesh", mesh.vertices, positions, 0)
    return faces


def check_edges(folder, tiles, positions, constraint_edges):
    """Checks constraint edges in PLY, which meshio refuses."""
    path = folder / "edges.ply"
    _, edges = export(tiles, path, "--edges")
    same("ply: edges", edges, constraint_edges)
    mesh = load(path)
    near("ply with edges: vertices by trimesh", mesh.vertices, positions, 0)
    if edges:
        found = mesh.metadata["_ply_raw"]["edge"]["data"]
        same("ply: edges by trimesh", len(found), edges)


def check_glb(folder, tiles, positions, faces, options):
    path = folder / "mesh.glb"
    export(tiles, path, *options)
    gltf = pygltflib.GLTF2().load(path)
    accessors = gltf.accessors
    same("glb: vertices and indices", [a.count for a in accessors], [len(positions), faces.size])
    blob = gltf.binary_blob()
    found = numpy.frombuffer(blob, "<f4", 3 * len(positions)).reshape(-1, 3)
    same("glb: bounds", (accessors[0].min, accessors[0].max), (found.min(0).tolist(), found.max(0).tolist()))
    indices = numpy.frombuffer(blob, "<u4", faces.size, gltf.bufferViews[accessors[1].bufferView].byteOffset)
    near("glb: triangles", indices.reshape(-1, 3), faces, 0)
    found = found.astype(float) + gltf.nodes[0].translation
    extent = numpy.ptp(positions, axis=0).max()
    near("glb: vertices", numpy.column_stack([found[:, 0], -found[:, 2], found[:, 1]]), positions, 1e-7 * extent)


def check_node(folder, tiles, positions, faces, options):
    """Triangle's format: comments, a line of counts, then a line for each vertex or triangle."""
    export(tiles, folder / "mesh.node", *options)
    for name, columns, expected in [("mesh.node", positions.shape[1], positions), ("mesh.ele", 3, faces)]:
        lines = [line for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
        count = int(lines[0].split()[0])
        same(f"{name}: count", count, len(expected))
        table = numpy.loadtxt(lines[1:], ndmin=2)
        first = table[0, 0]
        near(f"{name}: numbers", table[:, 0] - first, numpy.arange(count), 0)
        base = first if name == "mesh.ele" else 0
        near(name, table[:, 1 : 1 + columns] - base, expected, 0)


def check(folder, tiles, inspected, positions):
    """Reads the meshes with all triangles and without those in holes, and compares them with the vertices."""
    in_space = positions
    if positions.shape[1] == 2:
        in_space = numpy.column_stack([positions, numpy.zeros(len(positions))])
    counts = {"--all": inspected["triangles"], None: inspected["triangles"] - inspected["hole_triangles"]}
    for option, triangles in counts.items():
        options = [option] if option else []
        faces = check_ply_and_obj(folder, tiles, in_space, options)
        same(f"triangles {option or ''}", len(faces), triangles)
        check_glb(folder, tiles, in_space, faces, options)
        check_node(folder, tiles, positions, faces, options)
    check_edges(folder, tiles, in_space, inspected["constraint_edges"])
