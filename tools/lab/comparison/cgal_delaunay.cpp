// Triangulates raw points with CGAL and writes the corners of the triangles: points.f64 corners.u32
#include "raw.hpp"
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>>;

int main(int, char** arguments) {
    std::vector<std::pair<Kernel::Point_2, std::uint32_t>> points;
    {
        auto numbers = read<double>(arguments[1]);
        for (std::size_t i = 0; i < numbers.size(); i += 2)
            points.emplace_back(Kernel::Point_2(numbers[i], numbers[i + 1]), i / 2);
    }
    Delaunay triangulation(points.begin(), points.end());
    write(triangulation, arguments[2]);
}
