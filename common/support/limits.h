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
inline constexpr double uv_max = 1e6;            ///< texture coordinates lie in [-uv_max, uv_max]
inline constexpr double refractive_index_max = 10;
inline constexpr double photometric_max = 1e15;    ///< luminance [cd/m2] and intensity [cd]
inline constexpr double light_sample_max = 1e15;   ///< of a light's relative spectrum
inline constexpr double aspect_max = 1'000;        ///< of a camera; its inverse is the least
inline constexpr std::size_t json_depth_max = 64;  ///< of a glTF file
inline constexpr std::size_t json_values_max = 20'000'000;
inline constexpr std::size_t node_depth_max = 256;  ///< of an imported scene graph
inline constexpr std::size_t warnings_max = 200;    ///< of one import; more are counted

// Particles and ticks
inline constexpr std::uint64_t particles_max = std::uint64_t{1} << 32;  ///< of one job, all lights together
inline constexpr std::uint32_t bounces_max = 4'096;  ///< safety bound on the hits of a path; reaching it is reported
inline constexpr std::uint32_t energy_ticks_nominal = std::uint32_t{1}
                                                      << 16;               ///< mean energy of a particle at its start
inline constexpr std::uint32_t energy_ticks_max = std::uint32_t{1} << 19;  ///< of any particle at any time
/// The sum over everything that a job can add to one cell stays within int64 (law 3).
static_assert(particles_max <= (std::uint64_t{1} << 63) / energy_ticks_max / bounces_max);

// Solution
inline constexpr std::uint32_t texel_rows_max = 1'024;  ///< barycentric grid of one triangle is n x n with n up to this
inline constexpr std::uint64_t texels_max = 400'000'000;  ///< both sides counted
inline constexpr std::uint64_t kept_hits_max = 200'000'000;
inline constexpr std::uint32_t batches = 32;  ///< of particles, for standard errors

// Jobs
inline constexpr std::int64_t priority_max = 1'000;

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

// Farm: leases, results and who takes part
inline constexpr std::uint64_t first_set_particles = 1'000;  ///< of an automatic set while a worker's pace is unknown
inline constexpr std::uint64_t last_set_particles = 256;     ///< guided sets do not shrink below this
inline constexpr std::uint64_t slice_particles = 1'024;      ///< traced between two looks at whether to stop
inline constexpr std::size_t result_close_bytes = 8u << 20;  ///< a worker closes a result that has grown to this
inline constexpr std::size_t map_bytes_max = 64u << 20;      ///< dense sums of a job that is packed as maps
inline constexpr std::size_t claims_per_result_max = 16'384;
inline constexpr std::size_t staged_result_bytes_max = std::size_t{320} << 20;  ///< of one session's open result
inline constexpr std::size_t staged_bytes_max = std::size_t{4} << 30;           ///< of all open results together
inline constexpr std::uint32_t results_in_flight = 8;  ///< credit: results sent and not yet answered, a worker
inline constexpr std::uint32_t threads_per_worker_max = 1'024;
inline constexpr std::uint32_t leases_per_worker_max = 4 * threads_per_worker_max;
inline constexpr std::size_t sessions_max = 4'096;
inline constexpr std::size_t jobs_max = 4'096;      ///< kept by one master, finished ones included
inline constexpr std::size_t chunks_in_flight = 4;  ///< of one scene on its way to one worker
inline constexpr double lease_seconds = 60;         ///< without a sign of life from the worker
inline constexpr double reconnect_seconds = 10;     ///< leases of a lost connection wait for their worker this long
inline constexpr double finish_seconds = 10;        ///< an interrupted job waits for outstanding results this long
inline constexpr double drain_seconds = 10;         ///< a stopped worker may take this long to hand back its work
/// A result that closes late, after the longest possible slice, still fits: records, energies and kept copies of them.
static_assert(result_close_bytes + slice_particles * bounces_max * (hit_record_bytes + hit_energy_bytes + 32) +
                  map_bytes_max <=
              staged_result_bytes_max);

}  // namespace lumenfarm::limits
