// Reads and writes raw numbers.
#include <cstdint>
#include <fstream>
#include <utility>
#include <vector>

template <class Number> std::vector<Number> read(const char* path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    std::vector<Number> numbers(file.tellg() / sizeof(Number));
    file.seekg(0).read(reinterpret_cast<char*>(numbers.data()), numbers.size() * sizeof(Number));
    return numbers;
}

template <class Triangulation> void write(const Triangulation& triangulation, const char* path) {
    std::ofstream file(path, std::ios::binary);
    for (auto face : triangulation.finite_face_handles())
        for (int corner = 0; corner < 3; ++corner) {
            std::uint32_t record = face->vertex(corner)->info();
            file.write(reinterpret_cast<const char*>(&record), sizeof record);
        }
}
