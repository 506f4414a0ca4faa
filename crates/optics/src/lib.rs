//! Light and ice without scenes: Fresnel and the closed form of a grain.
