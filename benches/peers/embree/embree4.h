// The few declarations of Embree 4 that the tracer needs, written from Embree's public documentation
// of its C interface, so that the library inside a Python wheel (which ships no headers) is enough.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sys/types.h>

extern "C" {

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;
using RTCDevice = RTCDeviceTy*;
using RTCScene = RTCSceneTy*;
using RTCGeometry = RTCGeometryTy*;

constexpr unsigned RTC_INVALID_GEOMETRY_ID = 0xffffffffU;
constexpr int RTC_GEOMETRY_TYPE_SPHERE_POINT = 50;
constexpr int RTC_BUFFER_TYPE_VERTEX = 1;
constexpr int RTC_FORMAT_FLOAT4 = 0x9004;
constexpr int RTC_BUILD_QUALITY_MEDIUM = 1;
constexpr int RTC_BUILD_QUALITY_HIGH = 2;
constexpr int RTC_SCENE_FLAG_COMPACT = 1 << 1;
constexpr int RTC_SCENE_FLAG_ROBUST = 1 << 2;
constexpr int RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS = 1 << 3;
constexpr int RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER = 1 << 1;
constexpr int RTC_RAY_QUERY_FLAG_INCOHERENT = 0;
constexpr int RTC_RAY_QUERY_FLAG_COHERENT = 1 << 16;
constexpr unsigned RTC_FEATURE_FLAG_SPHERE_POINT = 1U << 20;
constexpr unsigned RTC_FEATURE_FLAG_ALL = 0xffffffffU;
constexpr int RTC_DEVICE_PROPERTY_VERSION = 0;

struct alignas(16) RTCRay {
    float org_x, org_y, org_z, tnear;
    float dir_x, dir_y, dir_z, time;
    float tfar;
    unsigned mask, id, flags;
};

// Since 4.3 a hit also holds the number of the instance in an instance array.
struct alignas(16) RTCHit {
    float Ng_x, Ng_y, Ng_z, u, v;
    unsigned primID, geomID, instID, instPrimID;
};

struct RTCRayHit {
    RTCRay ray;
    RTCHit hit;
};

struct alignas(64) RTCRayHit16 {
    float org_x[16], org_y[16], org_z[16], tnear[16];
    float dir_x[16], dir_y[16], dir_z[16], time[16];
    float tfar[16];
    unsigned mask[16], id[16], flags[16];
    float Ng_x[16], Ng_y[16], Ng_z[16], u[16], v[16];
    unsigned primID[16], geomID[16], instID[16], instPrimID[16];
};

struct RTCRayQueryContext {
    unsigned instID, instPrimID;
};

struct RTCFilterFunctionNArguments {
    int* valid;
    void* geometryUserPtr;
    RTCRayQueryContext* context;
    void* ray;
    void* hit;
    unsigned N;
};
using RTCFilterFunctionN = void (*)(const RTCFilterFunctionNArguments*);

struct RTCIntersectArguments {
    int flags;
    unsigned feature_mask;
    RTCRayQueryContext* context;
    RTCFilterFunctionN filter;
    void (*intersect)(const void*);
    float minWidthDistanceFactor;
};

RTCDevice rtcNewDevice(const char* config);
void rtcReleaseDevice(RTCDevice);
ssize_t rtcGetDeviceProperty(RTCDevice, int property);
int rtcGetDeviceError(RTCDevice);
RTCScene rtcNewScene(RTCDevice);
void rtcReleaseScene(RTCScene);
void rtcSetSceneFlags(RTCScene, int flags);
void rtcSetSceneBuildQuality(RTCScene, int quality);
void rtcCommitScene(RTCScene);
RTCGeometry rtcNewGeometry(RTCDevice, int type);
void rtcSetSharedGeometryBuffer(RTCGeometry, int buffer_type, unsigned slot, int format, const void* data,
                                size_t byte_offset, size_t byte_stride, size_t items);
void rtcSetGeometryBuildQuality(RTCGeometry, int quality);
void rtcCommitGeometry(RTCGeometry);
unsigned rtcAttachGeometry(RTCScene, RTCGeometry);
void rtcReleaseGeometry(RTCGeometry);
void rtcIntersect1(RTCScene, RTCRayHit*, RTCIntersectArguments*);
void rtcIntersect16(const int* valid, RTCScene, RTCRayHit16*, RTCIntersectArguments*);
}
