// Triangulates raw points and segments with CGAL, and writes the corners: points.f64 corners.u32 segments.u32
#include "raw.hpp"
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using Face = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<Vertex, Face>;
using Tag = CGAL::No_constraint_intersection_requiring_constructions_tag;
using Constrained = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, Tag>;

int main(int, char** arguments) {
    auto numbers = read<double>(arguments[1]);
    auto ends = read<std::uint32_t>(arguments[3]);
    std::vector<std::pair<Kernel::Point_2, std::uint32_t>> points;
    for (std::size_t i = 0; i < numbers.size(); i += 2)
        points.emplace_back(Kernel::Point_2(numbers[i], numbers[i + 1]), i / 2);
    Constrained triangulation;
    triangulation.insert(points.begin(), points.end());
    // The segments are given by handles of vertices, which are found by record: nothing is located again.
    std::vector<Constrained::Vertex_handle> vertices(points.size());
    for (auto vertex : triangulation.finite_vertex_handles())
        vertices[vertex->info()] = vertex;
    for (std::size_t i = 0; i < ends.size(); i += 2)
        triangulation.insert_constraint(vertices[ends[i]], vertices[ends[i + 1]]);
    write(triangulation, arguments[2]);
}
