#pragma once

#include <cstddef>
#include <cstdint>

/// Every bound of the system, in one place. A limit is checked before memory is taken.
namespace lumenfarm::limits {

// Scene
inline constexpr std::uint64_t scene_bytes_max = std::uint64_t{16} << 30;  ///< a compiled scene as a file
inline constexpr std::uint64_t vertices_max = 400'000'000;
inline constexpr std::uint64_t triangles_max = 200'000'000;
inline constexpr std::uint32_t surfaces_max = 1'000'000;
inline constexpr std::uint32_t materials_max = 1'000'000;
inline constexpr std::uint32_t spectra_max = 4'000'000;
inline constexpr std::uint32_t lights_max = 65'536;
inline constexpr std::uint32_t cameras_max = 4'096;
inline constexpr std::uint32_t textures_max = 4'096;
inline constexpr std::uint32_t texture_side_max = 16'384;  ///< texels along one side of a texture
inline constexpr std::uint64_t texture_texels_max = 256'000'000;
inline constexpr std::size_t name_bytes_max = 1'024;
inline constexpr std::uint64_t import_file_bytes_max = std::uint64_t{8} << 30;
inline constexpr double coordinate_max_m = 1e7;  ///< positions lie in [-coordinate_max_m, coordinate_max_m]

// Particles and ticks
inline constexpr std::uint64_t particles_max = std::uint64_t{1} << 32;  ///< of one job, all lights together
inline constexpr std::uint32_t bounces_max = 4'096;  ///< safety bound on the hits of a path; reaching it is reported
inline constexpr std::uint32_t energy_ticks_nominal = std::uint32_t{1} << 16;  ///< mean energy of a particle at its start
inline constexpr std::uint32_t energy_ticks_max = std::uint32_t{1} << 19;      ///< of any particle at any time
/// The sum over everything that a job can add to one cell stays within int64 (law 3).
static_assert(particles_max <= (std::uint64_t{1} << 63) / energy_ticks_max / bounces_max);

// Solution
inline constexpr std::uint32_t texel_rows_max = 1'024;  ///< barycentric grid of one triangle is n x n with n up to this
inline constexpr std::uint64_t texels_max = 400'000'000;  ///< both sides counted
inline constexpr std::uint64_t kept_hits_max = 200'000'000;
inline constexpr std::uint32_t batches = 32;  ///< of particles, for standard errors

// Sets and messages
inline constexpr std::uint64_t particles_per_set_max = 50'000'000;
inline constexpr std::uint32_t hits_per_message_max = 60'000;
inline constexpr std::size_t hit_record_bytes = 16;
inline constexpr std::size_t hit_energy_bytes = 4;
inline constexpr std::size_t frame_header_bytes = 32;
inline constexpr std::size_t frame_payload_bytes_max = 2u << 20;
inline constexpr std::size_t hello_payload_bytes_max = 4'096;
inline constexpr std::size_t chunk_bytes = 1u << 20;  ///< of scenes and solutions on the wire
static_assert(frame_header_bytes + hits_per_message_max * (hit_record_bytes + hit_energy_bytes) + 4'096 <=
              frame_payload_bytes_max);
static_assert(chunk_bytes + 4'096 <= frame_payload_bytes_max);

}  // namespace lumenfarm::limits
