// What the tracer needs from the machine: CPU time, memory, the clock of a core, small vectors, random numbers.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>

inline double seconds(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}
inline double cpu_seconds() { return seconds(CLOCK_PROCESS_CPUTIME_ID); }
inline double wall_seconds() { return seconds(CLOCK_MONOTONIC); }

// Bytes of resident memory, now ("VmRSS:") or at most so far ("VmHWM:").
inline double resident_bytes(const char* key) {
    FILE* file = std::fopen("/proc/self/status", "r");
    if (!file) return 0;
    char line[256];
    double kib = 0;
    while (std::fgets(line, sizeof line, file))
        if (std::strncmp(line, key, std::strlen(key)) == 0) std::sscanf(line + std::strlen(key), "%lf", &kib);
    std::fclose(file);
    return kib * 1024;
}

// The clock in GHz: a chain of additions that each wait for the one before takes one cycle each.
inline double clock_ghz() {
    const uint64_t rounds = 4'000'000;
    double best = 0;
    for (int attempt = 0; attempt < 5; ++attempt) {
        uint64_t x = rounds;
        double start = seconds(CLOCK_THREAD_CPUTIME_ID);
        for (uint64_t i = 0; i < rounds; ++i) {
#if defined(__x86_64__)
            asm volatile(
                "add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n"
                "add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n add %1,%0\n"
                : "+r"(x) : "r"(i));
#elif defined(__aarch64__)
            asm volatile(
                "add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n"
                "add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n"
                "add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n add %0,%0,%1\n"
                : "+r"(x) : "r"(i));
#else
            return 0;
#endif
        }
        double ghz = 16e-9 * double(rounds) / (seconds(CLOCK_THREAD_CPUTIME_ID) - start);
        if (ghz > best) best = ghz;
    }
    return best;
}

struct Vec {
    float x, y, z;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(float s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec normalized(Vec a) { return (1.0f / std::sqrt(dot(a, a))) * a; }
// Mends the length of a vector that is of unit length but for rounding: one step of Newton's method.
inline Vec mended(Vec a) { return (1.5f - 0.5f * dot(a, a)) * a; }

// PCG-XSH-RR 64/32 (O'Neill 2014), one stream a path.
struct Random {
    uint64_t state, stream;
    Random() = default;
    Random(uint64_t pixel, uint64_t sample, uint64_t seed) {
        stream = (mixed(pixel * 0x9e3779b97f4a7c15ULL + sample) << 1) | 1;
        state = mixed(stream + seed * 0xd1342543de82ef95ULL);
    }
    static uint64_t mixed(uint64_t x) {
        x ^= x >> 32;
        x *= 0xd6e8feb86659fd93ULL;
        x ^= x >> 32;
        x *= 0xd6e8feb86659fd93ULL;
        return x ^ (x >> 32);
    }
    float uniform() {
        uint64_t old = state;
        state = old * 6364136223846793005ULL + stream;
        auto shifted = uint32_t(((old >> 18) ^ old) >> 27);
        auto turn = uint32_t(old >> 59);
        uint32_t bits = (shifted >> turn) | (shifted << ((32 - turn) & 31));
        return float(bits >> 8) * 0x1p-24f;
    }
};
