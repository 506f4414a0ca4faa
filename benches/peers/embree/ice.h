// Light in ice: Fresnel's decisions of a path from its entry into a grain to where it leaves the ice.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "embree4.h"
#include "snow.h"

constexpr uint32_t NONE = 0xffffffffU;

// Paths start this many radii from the centre of the grain that they leave, so that rounding seldom makes
// them meet it again: those that do are traced on from there, and a path that thereby starts inside its next
// grain enters it where it stands. Nothing is skipped, so this is no epsilon that light could leak through.
constexpr float OUTWARD = 1.00001f;

// Only nested dielectrics keep light for ever (see the README); nothing else ends a path.
constexpr uint32_t ENDLESS = 10'000'000;

// How overlapping grains are treated.
enum class Overlap {
    None,        // no grain overlaps another: a chord ends where its own sphere ends
    Neighbours,  // ice is the union of the grains; who overlaps whom is looked up in a table
    Traced,      // ice is the union of the grains; Embree finds the spheres that hold the end of a chord
    Surfaces,    // every surface of every sphere refracts, also inside other spheres (nested dielectrics)
};

struct Counters {
    uint64_t events = 0, visits = 0, traces = 0, self_hits = 0, inside_hits = 0, trapped = 0;
    void operator+=(const Counters& other) {
        events += other.events;
        visits += other.visits;
        traces += other.traces;
        self_hits += other.self_hits;
        inside_hits += other.inside_hits;
        trapped += other.trapped;
    }
};

// A path: where it last left a grain (a unit normal of that grain, or a plain origin) and its direction.
struct Path {
    Vec origin;         // world position, from which Embree traces
    Vec direction;      // unit length
    Vec normal;         // of grain `grain` at the origin, unit length
    uint32_t grain;     // grain that was left, NONE at the camera
    uint32_t pixel;
    uint32_t events;
    Random random;
};

struct Ice {
    const Snow& snow;
    RTCScene scene;
    Overlap overlap;
    bool ground;  // y < 0 is black
    float eta, inverse_eta;

    // Reflectance at an interface, from the cosines outside and inside.
    float fresnel(float outside, float inside) const {
        const float s = (outside - eta * inside) / (outside + eta * inside);
        const float p = (eta * outside - inside) / (eta * outside + inside);
        return 0.5f * (s * s + p * p);
    }

    void leave(Path& path, uint32_t grain, Vec normal, Vec direction) const {
        const Grain& g = snow.grains[grain];
        path.normal = mended(normal);
        path.origin = g.centre() + (g.radius * OUTWARD) * path.normal;
        path.direction = mended(direction);
        path.grain = grain;
    }

    // Normal of the grain where the path enters it, computed afresh from the grain that it left last, which
    // is more precise than Embree's distance along the ray.
    Vec entry(const Path& path, const Grain& g, float& cosine) const {
        Vec from;
        if (path.grain == NONE) {
            from = path.origin - g.centre();
        } else {
            const Grain& last = snow.grains[path.grain];
            from = last.radius * path.normal + (last.centre() - g.centre());
        }
        const Vec across = from - dot(from, path.direction) * path.direction;
        const float scale = 1.0f / g.radius;
        const float sine2 = scale * scale * dot(across, across);
        cosine = sine2 < 1.0f ? std::sqrt(1.0f - sine2) : 0.0f;
        return scale * across - cosine * path.direction;
    }

    // Follows the path through the grain that it meets. False if the ground swallowed it.
    bool visit(Path& path, uint32_t grain, Counters& count) const {
        const Grain& g = snow.grains[grain];
        float outside;
        const Vec normal = entry(path, g, outside);
        const float inside = std::sqrt(1.0f - (1.0f - outside * outside) * inverse_eta * inverse_eta);
        const float reflectance = fresnel(outside, inside);
        ++count.visits;
        ++path.events;
        if (path.random.uniform() < reflectance) {
            leave(path, grain, normal, path.direction + (2.0f * outside) * normal);
            return true;
        }
        const Vec direction = inverse_eta * path.direction + (outside * inverse_eta - inside) * normal;
        if (overlap == Overlap::None) return sphere(path, grain, normal, direction, outside, inside, reflectance);
        return united(path, grain, normal, mended(direction), count);
    }

    // A lone sphere: all its chords meet the surface at the same angle.
    bool sphere(Path& path, uint32_t grain, Vec normal, Vec direction, float outside, float inside,
                float reflectance) const {
        const Grain& g = snow.grains[grain];
        const bool low = ground && g.y < g.radius;
        for (;;) {
            normal = normal + (2.0f * inside) * direction;
            if (low && g.y + g.radius * normal.y < 0.0f) return false;
            ++path.events;
            if (path.random.uniform() >= reflectance) break;
            direction = direction - (2.0f * inside) * normal;
        }
        leave(path, grain, normal, eta * direction + (outside - eta * inside) * normal);
        return true;
    }

    // The union of overlapping spheres: a chord that ends inside other spheres goes on in the one that
    // reaches farthest.
    bool united(Path& path, uint32_t grain, Vec normal, Vec direction, Counters& count) const {
        for (uint32_t turns = 0;; ++turns) {
            Vec end = chord_end(normal, direction);
            while (go_on(grain, end, direction, count)) {
            }
            const Grain& g = snow.grains[grain];
            normal = normalized(end);
            if (ground && g.y + g.radius * normal.y < 0.0f) return false;
            ++path.events;
            const float inside = dot(direction, normal);
            const float sine2 = eta * eta * (1.0f - inside * inside);
            if (sine2 < 1.0f) {
                const float outside = std::sqrt(1.0f - sine2);
                if (path.random.uniform() >= fresnel(outside, inside)) {
                    leave(path, grain, normal, eta * direction + (outside - eta * inside) * normal);
                    return true;
                }
            }
            if (turns == 1'000'000) {  // as Snowgrain: an orbit that needs so long is let out and counted
                ++count.trapped;
                leave(path, grain, normal, normal);
                return true;
            }
            direction = mended(direction - (2.0f * inside) * normal);
        }
    }

    // From the point `normal` of the sphere to the far end of the chord, in radii from the centre.
    static Vec chord_end(Vec normal, Vec direction) {
        return normal - (2.0f * dot(normal, direction)) * direction;
    }

    // If the end of a chord lies inside other grains: moves to the one that ice reaches farthest in.
    bool go_on(uint32_t& grain, Vec& end, Vec direction, Counters& count) const {
        const Grain& g = snow.grains[grain];
        const Vec point = g.radius * end;
        uint32_t best = NONE;
        float farthest = 0.0f;
        Vec best_end{};
        auto consider = [&](uint32_t id) {
            const Grain& other = snow.grains[id];
            const Vec from = point + (g.centre() - other.centre());
            const float c = other.radius * other.radius - dot(from, from);
            if (c <= 0.0f || id == grain) return;
            const float b = dot(from, direction);
            const float reach = std::sqrt(b * b + c) - b;
            if (reach <= farthest) return;
            farthest = reach;
            best = id;
            best_end = (1.0f / other.radius) * (from + reach * direction);
        };
        if (overlap == Overlap::Neighbours) {
            for (uint32_t i = snow.first[grain]; i < snow.first[grain + 1]; ++i) consider(snow.neighbours[i]);
        } else {
            Found found;
            find_around(g.centre() + point, direction, 2.0f * widest_radius, found);
            ++count.traces;
            for (uint32_t i = 0; i < found.size; ++i) consider(found.ids[i]);
        }
        if (best == NONE) return false;
        grain = best;
        end = best_end;
        return true;
    }

    float widest_radius = 0.0f;

    // Spheres that a short ray meets: Embree's filter notes each and lets the ray go on.
    struct Found {
        RTCRayQueryContext context{NONE, NONE};
        uint32_t size = 0;
        std::array<uint32_t, 64> ids;
    };
    static void note(const RTCFilterFunctionNArguments* arguments) {
        auto* found = reinterpret_cast<Found*>(arguments->context);
        const auto* hit = static_cast<const RTCHit*>(arguments->hit);
        if (found->size < found->ids.size()) found->ids[found->size++] = hit->primID;
        arguments->valid[0] = 0;
    }
    void find_around(Vec point, Vec direction, float length, Found& found) const {
        RTCRayHit query{};
        query.ray = {point.x, point.y, point.z, 0.0f, direction.x, direction.y, direction.z, 0.0f, length, NONE, 0, 0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectArguments arguments{RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER, RTC_FEATURE_FLAG_ALL, &found.context,
                                        note, nullptr, 0.0f};
        rtcIntersect1(scene, &query, &arguments);
    }

    // Nested dielectrics: one surface of one sphere, met from outside or from inside.
    bool surface(Path& path, uint32_t grain, Vec hit_normal, Counters& count) const {
        if (path.events == ENDLESS) {
            ++count.trapped;
            return false;
        }
        const Grain& g = snow.grains[grain];
        const bool entering = dot(hit_normal, path.direction) < 0.0f;
        float half_chord;
        Vec normal = entry(path, g, half_chord);
        if (!entering) normal = normalized(normal + (2.0f * half_chord) * path.direction);
        ++path.events;
        const float cosine = std::fabs(dot(normal, path.direction));
        const float ratio = entering ? inverse_eta : eta;
        const float sine2 = (1.0f - cosine * cosine) * ratio * ratio;
        const Vec facing = entering ? normal : -1.0f * normal;
        Vec direction = path.direction + (2.0f * cosine) * facing;
        bool inward = !entering;
        if (sine2 < 1.0f) {
            const float beyond = std::sqrt(1.0f - sine2);
            const float reflectance = entering ? fresnel(cosine, beyond) : fresnel(beyond, cosine);
            if (path.random.uniform() >= reflectance) {
                direction = ratio * path.direction + (ratio * cosine - beyond) * facing;
                inward = entering;
            }
        }
        path.normal = normal;
        path.origin = g.centre() + (g.radius * (inward ? 2.0f - OUTWARD : OUTWARD)) * normal;
        path.direction = normalized(direction);
        path.grain = grain;
        return true;
    }
};
