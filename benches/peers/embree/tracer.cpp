// Light among spheres of ice, traced with Embree's sphere points: what a good programmer would write by
// hand today. No path cap, no roulette, no epsilon; the sky is 1 above the horizon and 0 below.
//
// Usage: tracer GRAINS.ply SUMS.bin [--option value]...; see `Options`. Prints one JSON object.
// SUMS.bin: per pixel, row by row, how many samples saw the sky: uint32.

#include <atomic>
#include <cstdlib>
#include <limits>
#include <map>
#include <thread>

#include "ice.h"

namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();
constexpr int CAPS[] = {12, 64, 256, 1024, 10000};
constexpr int CAP_COUNT = 5;
constexpr uint32_t TILE = 8;

struct Options {
    std::map<std::string, std::string> given;
    Options(int argc, char** argv) {
        for (int i = 3; i + 1 < argc; i += 2) given[argv[i]] = argv[i + 1];
    }
    std::string text(const char* key, const char* otherwise) const {
        auto found = given.find(key);
        return found == given.end() ? otherwise : found->second;
    }
    double number(const char* key, double otherwise) const {
        auto found = given.find(key);
        return found == given.end() ? otherwise : std::atof(found->second.c_str());
    }
};

struct Camera {
    double from[3], right[3], up[3], forward[3], half_width, half_height;
    uint32_t width, height;

    Camera(const Options& options, uint32_t width, uint32_t height) : width(width), height(height) {
        double at[3];
        std::sscanf(options.text("--from", "0,0,1").c_str(), "%lf,%lf,%lf", from, from + 1, from + 2);
        std::sscanf(options.text("--at", "0,0,0").c_str(), "%lf,%lf,%lf", at, at + 1, at + 2);
        half_height = std::tan(options.number("--fov", 40) * 3.14159265358979323846 / 360);
        half_width = half_height * width / height;
        for (int i = 0; i < 3; ++i) forward[i] = at[i] - from[i];
        unit(forward);
        const double vertical[3] = {0, 1, 0};
        cross(forward, vertical, right);
        unit(right);
        cross(right, forward, up);
    }
    static void unit(double* v) {
        const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (int i = 0; i < 3; ++i) v[i] /= length;
    }
    static void cross(const double* a, const double* b, double* c) {
        for (int i = 0; i < 3; ++i) c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
    Path path(uint32_t pixel, uint32_t sample, uint64_t seed) const {
        Path path;
        path.random = Random(pixel, sample, seed);
        const double x = 2 * (pixel % width + double(path.random.uniform())) / width - 1;
        const double y = 1 - 2 * (pixel / width + double(path.random.uniform())) / height;
        double d[3];
        for (int i = 0; i < 3; ++i) d[i] = forward[i] + x * half_width * right[i] + y * half_height * up[i];
        unit(d);
        path.origin = {float(from[0]), float(from[1]), float(from[2])};
        path.direction = {float(d[0]), float(d[1]), float(d[2])};
        path.normal = {0, 0, 0};
        path.grain = NONE;
        path.pixel = pixel;
        path.events = 0;
        return path;
    }
};

// What one thread has seen; threads share nothing while they trace.
struct alignas(128) Worker {
    Counters count;
    uint64_t paths_in_snow = 0, longest = 0;
    std::array<uint64_t, CAP_COUNT> light_within{};  // of marked pixels: paths that see the sky within a cap
    uint64_t marked_light = 0;
};

struct Renderer {
    Ice ice;
    Camera camera;
    RTCIntersectArguments arguments;
    uint32_t samples;
    uint64_t seed;
    std::vector<uint32_t> sums;       // per pixel
    std::vector<uint8_t> marked;      // pixels in the mean for caps
    std::atomic<uint32_t> next_tile{0};

    float reach(const Path& path) const {
        return ice.ground && path.direction.y < 0.0f ? -path.origin.y / path.direction.y : INFINITE;
    }

    // Ends a path that meets no grain: in the sky, or in the dark.
    void finish(const Path& path, Worker& worker) {
        worker.count.events += path.events;
        worker.paths_in_snow += path.events != 0;
        worker.longest = std::max<uint64_t>(worker.longest, path.events);
        if (path.direction.y <= 0.0f) return;
        ++sums[path.pixel];  // pixels belong to one tile, tiles to one thread
        if (!marked[path.pixel]) return;
        ++worker.marked_light;
        for (int i = 0; i < CAP_COUNT; ++i) worker.light_within[i] += path.events <= uint32_t(CAPS[i]);
    }
    void swallow(const Path& path, Worker& worker) {
        worker.count.events += path.events;
        worker.paths_in_snow += 1;
        worker.longest = std::max<uint64_t>(worker.longest, path.events);
    }

    // What follows a hit. False when the path has ended.
    bool meet(Path& path, uint32_t grain, Vec hit_normal, Worker& worker) {
        bool goes_on;
        if (ice.overlap == Overlap::Surfaces) {
            goes_on = ice.surface(path, grain, hit_normal, worker.count);
        } else {
            // Met from inside: by rounding the path starts within the sphere; it enters where it stands.
            worker.count.inside_hits += dot(hit_normal, path.direction) > 0.0f;
            goes_on = ice.visit(path, grain, worker.count);
        }
        if (!goes_on) swallow(path, worker);
        return goes_on;
    }

    // A hit on the sphere that the path has just left is rounding: look on behind it.
    static bool is_rounding(const Path& path, uint32_t grain, float distance, float radius, Overlap overlap) {
        return grain == path.grain && (overlap != Overlap::Surfaces || distance < 1e-3f * radius);
    }

    void trace_one(Path path, Worker& worker) {
        RTCRayHit query;
        for (;;) {
            float nearest = 0.0f;
            for (;;) {
                query.ray = {path.origin.x,    path.origin.y,    path.origin.z,    nearest, path.direction.x,
                             path.direction.y, path.direction.z, 0.0f, reach(path), NONE, 0, 0};
                query.hit.geomID = query.hit.instID = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(ice.scene, &query, &arguments);
                ++worker.count.traces;
                if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return finish(path, worker);
                if (!is_rounding(path, query.hit.primID, query.ray.tfar, ice.snow.grains[query.hit.primID].radius,
                                 ice.overlap))
                    break;
                ++worker.count.self_hits;
                nearest = std::nextafter(query.ray.tfar, INFINITE);
            }
            if (!meet(path, query.hit.primID, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, worker)) return;
        }
    }

    // Pixels and samples of a tile, in order: pixels along a Z curve, all samples of a pixel together.
    struct Supply {
        uint32_t tile_x, tile_y, next = 0, end;
    };
    bool next_path(Supply& supply, Path& path) const {
        if (supply.next == supply.end) return false;
        const uint32_t place = supply.next / samples, sample = supply.next % samples;
        ++supply.next;
        auto every_other = [](uint32_t v) { return (v & 1) | (v >> 1 & 2) | (v >> 2 & 4); };
        const uint32_t x = supply.tile_x * TILE + every_other(place), y = supply.tile_y * TILE + every_other(place >> 1);
        path = camera.path(y * camera.width + x, sample, seed);
        return true;
    }

    // Sixteen paths in lanes; a path that ends makes room for the next of the tile.
    void trace_packets(Supply supply, Worker& worker) {
        Path paths[16];
        alignas(64) int valid[16];
        float nearest[16] = {};
        RTCRayHit16 query;
        int alive = 0;
        for (int lane = 0; lane < 16; ++lane) {
            valid[lane] = next_path(supply, paths[lane]) ? -1 : 0;
            alive += valid[lane] != 0;
        }
        while (alive) {
            for (int lane = 0; lane < 16; ++lane) {
                const Path& path = paths[lane];
                query.org_x[lane] = path.origin.x;
                query.org_y[lane] = path.origin.y;
                query.org_z[lane] = path.origin.z;
                query.tnear[lane] = nearest[lane];
                query.dir_x[lane] = path.direction.x;
                query.dir_y[lane] = path.direction.y;
                query.dir_z[lane] = path.direction.z;
                query.time[lane] = 0.0f;
                query.tfar[lane] = reach(path);
                query.mask[lane] = NONE;
                query.flags[lane] = query.id[lane] = 0;
                query.geomID[lane] = query.instID[lane] = RTC_INVALID_GEOMETRY_ID;
            }
            rtcIntersect16(valid, ice.scene, &query, &arguments);
            worker.count.traces += alive;
            for (int lane = 0; lane < 16; ++lane) {
                if (!valid[lane]) continue;
                Path& path = paths[lane];
                nearest[lane] = 0.0f;
                const uint32_t grain = query.primID[lane];
                bool goes_on = false;
                if (query.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
                    finish(path, worker);
                } else if (is_rounding(path, grain, query.tfar[lane], ice.snow.grains[grain].radius, ice.overlap)) {
                    ++worker.count.self_hits;
                    nearest[lane] = std::nextafter(query.tfar[lane], INFINITE);
                    goes_on = true;
                } else {
                    goes_on = meet(path, grain, {query.Ng_x[lane], query.Ng_y[lane], query.Ng_z[lane]}, worker);
                }
                if (!goes_on && !next_path(supply, path)) {
                    valid[lane] = 0;
                    --alive;
                }
            }
        }
    }

    void work(Worker& worker, bool packets) {
        const uint32_t across = camera.width / TILE, tiles = across * (camera.height / TILE);
        for (uint32_t tile; (tile = next_tile.fetch_add(1)) < tiles;) {
            Supply supply{tile % across, tile / across, 0, TILE * TILE * samples};
            if (packets) {
                trace_packets(supply, worker);
            } else {
                for (Path path; next_path(supply, path);) trace_one(path, worker);
            }
        }
    }
};

Overlap overlap_named(const std::string& name) {
    if (name == "none") return Overlap::None;
    if (name == "neighbours") return Overlap::Neighbours;
    if (name == "traced") return Overlap::Traced;
    if (name == "surfaces") return Overlap::Surfaces;
    throw std::runtime_error("--overlap is none, neighbours, traced or surfaces, not " + name);
}

std::vector<uint8_t> read_marks(const std::string& path, size_t pixels) {
    std::vector<uint8_t> marks(pixels, 1);
    if (path.empty()) return marks;
    FILE* file = std::fopen(path.c_str(), "rb");
    if (!file || std::fread(marks.data(), 1, pixels, file) != pixels) throw std::runtime_error("cannot read " + path);
    std::fclose(file);
    return marks;
}

int run(int argc, char** argv) {
    if (argc < 3) throw std::runtime_error("usage: tracer GRAINS.ply SUMS.bin [--option value]...");
    const Options options(argc, argv);
    const auto threads = unsigned(options.number("--threads", 2));
    const auto size = uint32_t(options.number("--size", 256));
    if (size % TILE) throw std::runtime_error("--size must be a multiple of 8");
    const bool packets = options.number("--packets", 1) > 1;
    const Overlap overlap = overlap_named(options.text("--overlap", "none"));
    const bool high = options.text("--quality", "medium") == "high";
    const bool robust = options.text("--robust", "no") == "yes";
    const bool compact = options.text("--compact", "no") == "yes";
    const bool coherent = options.text("--coherent", "no") == "yes";

    const std::string config = "threads=" + std::to_string(threads) + "," + options.text("--config", "");
    RTCDevice device = rtcNewDevice(config.c_str());
    const auto version = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
    if (version < 40300 || version >= 50000) throw std::runtime_error("Embree 4.3 or a later 4.x is needed");
    const double empty_bytes = resident_bytes("VmRSS:");

    double load_start = cpu_seconds();
    Snow snow(argv[1]);
    if (options.text("--sort", "yes") == "yes") snow.sort_along_z_curve();
    if (overlap == Overlap::Neighbours) snow.find_neighbours();
    const double load_cpu = cpu_seconds() - load_start;
    const size_t grains = snow.grains.size();

    const double build_start = cpu_seconds();
    RTCScene scene = rtcNewScene(device);
    int flags = overlap == Overlap::Traced ? RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS : 0;
    if (robust) flags |= RTC_SCENE_FLAG_ROBUST;
    if (compact) flags |= RTC_SCENE_FLAG_COMPACT;
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, high ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, snow.grains.data(), 0, sizeof(Grain),
                               grains);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device)) throw std::runtime_error("Embree reports an error");
    const double build_cpu = cpu_seconds() - build_start, built_bytes = resident_bytes("VmRSS:");

    const auto eta = float(options.number("--ior", 1.31));
    Renderer renderer{Ice{snow, scene, overlap, options.text("--ground", "no") == "yes", eta, 1.0f / eta},
                      Camera(options, size, size),
                      {coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT, RTC_FEATURE_FLAG_SPHERE_POINT,
                       nullptr, nullptr, nullptr, 0.0f},
                      uint32_t(options.number("--spp", 16)),
                      uint64_t(options.number("--seed", 0)),
                      std::vector<uint32_t>(size_t(size) * size),
                      read_marks(options.text("--marks", ""), size_t(size) * size)};
    for (const Grain& g : snow.grains) renderer.ice.widest_radius = std::max(renderer.ice.widest_radius, g.radius);

    const double ghz = clock_ghz();
    std::vector<Worker> workers(threads);
    const double start_wall = wall_seconds(), start_cpu = cpu_seconds();
    std::vector<std::thread> team;
    for (Worker& worker : workers) team.emplace_back([&] { renderer.work(worker, packets); });
    for (std::thread& thread : team) thread.join();
    const double wall = wall_seconds() - start_wall, cpu = cpu_seconds() - start_cpu;

    Worker all;
    for (const Worker& worker : workers) {
        all.count += worker.count;
        all.paths_in_snow += worker.paths_in_snow;
        all.longest = std::max(all.longest, worker.longest);
        all.marked_light += worker.marked_light;
        for (int i = 0; i < CAP_COUNT; ++i) all.light_within[i] += worker.light_within[i];
    }
    FILE* file = std::fopen(argv[2], "wb");
    if (!file || std::fwrite(renderer.sums.data(), 4, renderer.sums.size(), file) != renderer.sums.size() || std::fclose(file))
        throw std::runtime_error(std::string("cannot write ") + argv[2]);

    const Counters& c = all.count;
    std::printf("{\"version\": \"%zd.%zd.%zd\", \"grains\": %zu, \"clock_ghz\": %.3f, \"clock_ghz_after\": %.3f,\n", version / 10000,
                version / 100 % 100, version % 100, grains, ghz, clock_ghz());
    std::printf("\"load_cpu_seconds\": %.4f, \"build_cpu_seconds\": %.4f, \"empty_bytes\": %.0f, \"built_bytes\": %.0f,\n", load_cpu,
                build_cpu, empty_bytes, built_bytes);
    std::printf("\"peak_bytes\": %.0f, \"render_seconds\": %.4f, \"render_cpu_seconds\": %.4f,\n", resident_bytes("VmHWM:"), wall, cpu);
    std::printf("\"samples\": %llu, \"paths_in_snow\": %llu, \"events\": %llu, \"visits\": %llu, \"traces\": %llu,\n",
                (unsigned long long)size * size * renderer.samples, (unsigned long long)all.paths_in_snow,
                (unsigned long long)c.events, (unsigned long long)c.visits, (unsigned long long)c.traces);
    std::printf("\"self_hits\": %llu, \"inside_hits\": %llu, \"trapped\": %llu, \"longest_path\": %llu,\n",
                (unsigned long long)c.self_hits, (unsigned long long)c.inside_hits, (unsigned long long)c.trapped,
                (unsigned long long)all.longest);
    std::printf("\"light_within_cap\": {");
    for (int i = 0; i < CAP_COUNT; ++i)
        std::printf("%s\"%d\": %.6f", i ? ", " : "", CAPS[i], double(all.light_within[i]) / double(std::max<uint64_t>(all.marked_light, 1)));
    std::printf("}}\n");
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "tracer: %s\n", error.what());
        return 1;
    }
}
