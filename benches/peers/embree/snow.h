// Grains: read from the PLY that `snowgrain deposit` writes; for overlapping grains, who overlaps whom.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "machine.h"

struct Grain {
    float x, y, z, radius;
    Vec centre() const { return {x, y, z}; }
};

struct Snow {
    std::vector<Grain> grains;
    // Grains that overlap grain i: neighbours[first[i]] to neighbours[first[i + 1] - 1].
    std::vector<uint32_t> first, neighbours;

    explicit Snow(const char* path) {
        FILE* file = std::fopen(path, "rb");
        if (!file) throw std::runtime_error(std::string("cannot open ") + path);
        char line[256];
        size_t count = 0, properties = 0;
        const char* wanted[] = {"property double x", "property double y", "property double z", "property float radius"};
        while (std::fgets(line, sizeof line, file)) {
            line[std::strcspn(line, "\r\n")] = 0;
            std::sscanf(line, "element vertex %zu", &count);
            if (std::strncmp(line, "property", 8) == 0 && (properties > 3 || std::strcmp(line, wanted[properties++]) != 0))
                throw std::runtime_error("the grain file must hold double x y z, float radius");
            if (std::strcmp(line, "end_header") == 0) break;
        }
        grains.reserve(count + 1);
        char record[28];
        for (size_t i = 0; i < count; ++i) {
            if (std::fread(record, sizeof record, 1, file) != 1) throw std::runtime_error("the grain file ends early");
            double centre[3];
            Grain grain;
            std::memcpy(centre, record, 24);
            std::memcpy(&grain.radius, record + 24, 4);
            grain.x = float(centre[0]);
            grain.y = float(centre[1]);
            grain.z = float(centre[2]);
            grains.push_back(grain);
        }
        std::fclose(file);
    }

    // Orders grains along a Z curve, so that Embree's leaves read neighbouring grains from the same cache lines.
    void sort_along_z_curve() {
        Vec low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
        for (const Grain& g : grains) {
            low = {std::min(low.x, g.x), std::min(low.y, g.y), std::min(low.z, g.z)};
            high = {std::max(high.x, g.x), std::max(high.y, g.y), std::max(high.z, g.z)};
        }
        const float side = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-30f});
        auto spread = [](uint64_t v) {
            v = (v | v << 32) & 0x1f00000000ffffULL;
            v = (v | v << 16) & 0x1f0000ff0000ffULL;
            v = (v | v << 8) & 0x100f00f00f00f00fULL;
            v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
            return (v | v << 2) & 0x1249249249249249ULL;
        };
        auto place = [&](float v, float lowest) { return spread(uint64_t((v - lowest) / side * 1048575.0f)); };
        struct Keyed {
            uint64_t key;
            Grain grain;
        };
        std::vector<Keyed> keyed;
        keyed.reserve(grains.size());
        for (const Grain& g : grains) keyed.push_back({place(g.x, low.x) | place(g.y, low.y) << 1 | place(g.z, low.z) << 2, g});
        std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
        for (size_t i = 0; i < grains.size(); ++i) grains[i] = keyed[i].grain;
    }

    // Sorts grains into cells as wide as the largest grain, so that overlaps lie in adjacent cells.
    void find_neighbours() {
        Vec low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
        float widest = 0;
        for (const Grain& g : grains) {
            low = {std::min(low.x, g.x), std::min(low.y, g.y), std::min(low.z, g.z)};
            high = {std::max(high.x, g.x), std::max(high.y, g.y), std::max(high.z, g.z)};
            widest = std::max(widest, 2 * g.radius);
        }
        const int nx = int((high.x - low.x) / widest) + 1, ny = int((high.y - low.y) / widest) + 1,
                  nz = int((high.z - low.z) / widest) + 1;
        auto column = [&](float v, float lowest) { return int((v - lowest) / widest); };
        auto cell_of = [&](const Grain& g) {
            return (size_t(column(g.z, low.z)) * ny + column(g.y, low.y)) * nx + column(g.x, low.x);
        };
        std::vector<uint32_t> start(size_t(nx) * ny * nz + 1), member(grains.size());
        for (const Grain& g : grains) ++start[cell_of(g) + 1];
        for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
        std::vector<uint32_t> next(start.begin(), start.end() - 1);
        for (uint32_t i = 0; i < grains.size(); ++i) member[next[cell_of(grains[i])]++] = i;
        first.push_back(0);
        for (uint32_t i = 0; i < grains.size(); ++i) {
            const Grain& g = grains[i];
            const int cx = column(g.x, low.x), cy = column(g.y, low.y), cz = column(g.z, low.z);
            for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, nz - 1); ++z)
                for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, ny - 1); ++y) {
                    const size_t row = (size_t(z) * ny + y) * nx;
                    const uint32_t end = start[row + std::min(cx + 1, nx - 1) + 1];
                    for (uint32_t m = start[row + std::max(cx - 1, 0)]; m < end; ++m) {
                        const Grain& other = grains[member[m]];
                        const Vec apart = other.centre() - g.centre();
                        const float reach = g.radius + other.radius;
                        if (member[m] != i && dot(apart, apart) < reach * reach) neighbours.push_back(member[m]);
                    }
                }
            first.push_back(uint32_t(neighbours.size()));
        }
        neighbours.shrink_to_fit();
    }
};
