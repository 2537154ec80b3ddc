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

// Octree
inline constexpr std::uint32_t octree_depth_max = 20;
inline constexpr std::uint64_t octree_nodes_max = 268'435'456;
inline constexpr std::uint64_t octree_references_max = 2'000'000'000;  ///< triangles in leaves, repeats counted
inline constexpr std::uint32_t octree_threads_max = 64;

inline constexpr std::uint32_t subspaces_max = 65'536;  ///< that a scene is cut into

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
inline constexpr std::uint64_t solution_bytes_max = std::uint64_t{32} << 30;  ///< a solution as a file
static_assert(texels_max * 48 + kept_hits_max * 24 + (std::uint64_t{1} << 30) <= solution_bytes_max);
inline constexpr std::uint32_t batches = 32;  ///< of particles, for standard errors

// Products
inline constexpr std::uint32_t picture_side_max = 16'384;  ///< pixels
inline constexpr std::uint32_t samples_per_side_max = 16;  ///< camera rays along one side of a pixel
inline constexpr std::uint64_t points_file_bytes_max = std::uint64_t{1} << 30;
inline constexpr std::uint64_t points_max = 10'000'000;  ///< rows of one `measure`

// Jobs
inline constexpr std::int64_t priority_max = 1'000;

// Sets and messages
inline constexpr std::uint64_t particles_per_set_max = 50'000'000;
inline constexpr std::uint32_t hits_per_message_max = 60'000;
inline constexpr std::size_t hit_record_bytes = 16;
inline constexpr std::size_t hit_energy_bytes = 4;
inline constexpr std::size_t flight_record_bytes = 80;
inline constexpr std::uint32_t flights_per_message_max = 16'384;
inline constexpr std::size_t frame_header_bytes = 32;
inline constexpr std::size_t frame_payload_bytes_max = 2u << 20;
inline constexpr std::size_t hello_payload_bytes_max = 4'096;
inline constexpr std::size_t chunk_bytes = 1u << 20;  ///< of scenes and solutions on the wire
static_assert(frame_header_bytes + hits_per_message_max * (hit_record_bytes + hit_energy_bytes) + 4'096 <=
              frame_payload_bytes_max);
static_assert(frame_header_bytes + flights_per_message_max * flight_record_bytes + 4'096 <= frame_payload_bytes_max);
static_assert(chunk_bytes + 4'096 <= frame_payload_bytes_max);

// Farm: leases, results and who takes part
inline constexpr std::uint64_t first_set_particles = 1'000;  ///< of a worker's first automatic sets
inline constexpr double first_flush_seconds = 0.1;           ///< until a worker's first result of a job, at most
inline constexpr std::uint64_t last_set_particles = 256;     ///< guided sets do not shrink below this
inline constexpr std::uint64_t slice_particles = 1'024;      ///< traced between two looks at whether to stop
/// Where the scene is there in parts: those of a slice spread over the subspaces, and a few alone take long.
inline constexpr std::uint64_t slice_particles_in_parts = 16'384;
inline constexpr std::uint64_t flights_at_once = 512;  ///< through one subspace
static_assert(flights_at_once < slice_particles);
/// A slice through parts ends where it has so many hits, and what flights_at_once may add.
inline constexpr std::uint64_t hits_per_slice_max = (slice_particles - flights_at_once) * bounces_max;
inline constexpr std::size_t result_close_bytes = 8u << 20;      ///< a worker closes a result that has grown to this
inline constexpr std::size_t map_bytes_max = 64u << 20;          ///< dense sums of a job that is packed as maps
inline constexpr std::uint64_t flights_waiting_max = 1'000'000;  ///< in subspaces; with more no light emits
inline constexpr std::uint64_t flights_per_worker_max = 65'536;  ///< in its leases; half its outbox
inline constexpr std::uint64_t part_bytes_per_triangle = 300;    ///< that a worker takes to trace in a subspace
inline constexpr std::uint64_t part_bytes = 256u << 10;          ///< beside that, a subspace
inline constexpr std::uint64_t plan_bytes_factor = 4;            ///< in memory, times those of the file
inline constexpr std::uint64_t worker_bytes = 64u << 20;         ///< that a worker takes without a job
inline constexpr std::size_t claims_per_result_max = 16'384;
inline constexpr std::size_t staged_result_bytes_max = std::size_t{320} << 20;  ///< of one session's open result
inline constexpr std::size_t staged_bytes_max = std::size_t{4} << 30;           ///< of all open results together
inline constexpr std::uint32_t results_in_flight = 8;  ///< credit: results sent and not yet answered, a worker
inline constexpr std::uint32_t results_in_flight_max = 256;
inline constexpr double result_seconds_max = 1e9;        ///< that a result may say it took
inline constexpr std::size_t repeated_results_max = 16;  ///< that wait for one that is on its way to the disk
inline constexpr std::uint32_t invalid_results_max = 3;  ///< then a worker is sent off
inline constexpr std::size_t active_jobs_max = 4;        ///< with their sums in memory
inline constexpr std::size_t cut_lessons_max = 32;       ///< of a job's cuts in subspaces; later ones teach nothing
inline constexpr std::size_t admissions_max = 64;        ///< submissions that wait for the disk
inline constexpr std::uint32_t threads_per_worker_max = 1'024;
inline constexpr std::uint32_t threads_behind_relay_max = 1u << 20;
inline constexpr std::size_t relay_bytes_in_flight = std::size_t{256}
                                                     << 20;  ///< of a relay's results handed up and not answered
inline constexpr std::uint32_t relay_sets_ahead = 4;  ///< leases with particles that a relay's workers have not got
inline constexpr std::uint32_t leases_of_relay = 3 * relay_sets_ahead;  ///< at once, about
inline constexpr std::uint32_t leases_per_worker_max = 4 * threads_per_worker_max;
inline constexpr std::size_t sessions_max = 4'096;
inline constexpr std::size_t jobs_max = 4'096;  ///< kept by one master, finished ones included
inline constexpr std::size_t job_record_bytes_max = 64u << 10;
// A job's results are written as one solution when they are more than this, have so many times the bytes of the job's
// sums, or so many bytes more; earlier for room on the disk.
inline constexpr std::uint64_t results_per_snapshot_max = 10'000;
inline constexpr std::uint64_t snapshot_times_sums = 8;
inline constexpr std::uint64_t snapshot_bytes_beside_sums = std::uint64_t{1} << 30;
inline constexpr double disk_retry_seconds = 5;         ///< after the disk was full
inline constexpr double restart_seconds = 45;           ///< leases wait this long for their workers after a restart
inline constexpr std::size_t chunks_in_flight = 4;      ///< of one scene on its way to one worker
inline constexpr std::uint32_t chunk_attempts_max = 3;  ///< of a chunk that comes damaged
inline constexpr std::size_t result_bytes_in_flight =
    16u << 20;                                         ///< of the results sent and not yet answered, beside the last
inline constexpr std::size_t uploads_max = 16;         ///< of scenes on their way to one master
inline constexpr double lease_seconds = 60;            ///< without a sign of life from the worker
inline constexpr std::uint32_t losses_max = 3;         ///< a set that was lost so often with its worker is set aside
inline constexpr std::uint32_t set_aside_retries = 2;  ///< when nothing else is left
inline constexpr double set_aside_seconds = 10;        ///< before the first of them; four times as long before the next
inline constexpr double retry_seconds = 1;        ///< a lost set waits this long; after the next loss twice as long
inline constexpr double audit_seconds = 60;       ///< to trace a result again; beside some times what it took at first
inline constexpr std::size_t audits_max = 4'096;  ///< that are under way, or wait
inline constexpr double audit_slowness_max = 5;   ///< times what it took at first
inline constexpr double audit_patiences_max = 4;  ///< times as long an audit may take in all, over several workers
inline constexpr double reconnect_seconds = 10;   ///< leases of a lost connection wait for their worker this long; a
                                                  ///< master may be told otherwise
inline constexpr double finish_seconds = 10;      ///< an interrupted job waits for outstanding results this long
inline constexpr double straggler_targets =
    3;  ///< a lease overdue by this many target times may be traced again by an idle worker
inline constexpr double drain_seconds = 10;  ///< a stopped worker may take this long to hand back its work
inline constexpr double drain_seconds_max = 86'400;
inline constexpr double stop_seconds = 10;  ///< a stopped master waits this long for results on their way to its disk
inline constexpr double busy_seconds_max = 3'600;  ///< a thread that computes need not answer the watchdog for so long
/// A result that closes late, after the longest possible slice, still fits: records, energies and kept copies of them,
/// and flights.
static_assert(result_close_bytes + slice_particles * bounces_max * (hit_record_bytes + hit_energy_bytes + 32) +
                  slice_particles_in_parts * flight_record_bytes + map_bytes_max <=
              staged_result_bytes_max);

// Wire: sessions, work and results. Payload caps by message type stand in proto/message_type.h.
inline constexpr std::size_t texel_delta_bytes = 48;
inline constexpr std::size_t surface_delta_bytes = 32;
inline constexpr std::size_t kept_hit_bytes = 24;
inline constexpr std::uint32_t texel_deltas_per_message_max = 24'000;
inline constexpr std::uint32_t surface_deltas_per_message_max = 24'000;
/// A worker sends its map before it holds more; so that the hits of a texel fit 32 bits.
inline constexpr std::uint64_t hits_per_map_max = std::uint64_t{1} << 31;
inline constexpr std::uint32_t parts_per_result_max = 65'536;
inline constexpr std::uint32_t chunks_max = 32'768;       ///< of one chunked file
inline constexpr std::uint32_t jobs_listed_max = 1'000;   ///< in one status reply
inline constexpr std::uint32_t set_aside_listed_max = 8;  ///< ranges of particles in the status of a job
inline constexpr std::size_t reason_counts_max = 256;     ///< in one status reply
inline constexpr std::size_t reason_name_bytes_max = 32;
inline constexpr std::size_t peer_name_bytes_max = 255;
inline constexpr std::size_t address_bytes_max = 64;
inline constexpr std::size_t isa_bytes_max = 32;
inline constexpr std::size_t sentence_bytes_max = 1'024;
inline constexpr unsigned archive_depth_max = 8;
inline constexpr std::size_t message_memory_bytes_max = 8u << 20;  ///< that decoding one message may take

// Connections
inline constexpr double hello_seconds = 5;  ///< from accept to a whole Hello
inline constexpr double dead_seconds = 15;  ///< of silence; a master may be told otherwise
inline constexpr double dead_seconds_min = 0.5;
inline constexpr double dead_seconds_max = 60;
inline constexpr double heartbeats_per_dead = 3;
inline constexpr double heartbeat_seconds = dead_seconds / heartbeats_per_dead;
inline constexpr double connect_seconds = 5;
inline constexpr double accept_retry_seconds = 0.1;  ///< after accepting failed for want of descriptors
inline constexpr double reply_seconds = 60;          ///< to a request, while the peer is alive
inline constexpr double submit_seconds = 600;        ///< to a Submit: the master reads the whole scene
inline constexpr double goodbye_seconds = 2;         ///< for the last bytes to leave before a close
inline constexpr double reconnect_seconds_min = 0.5;
inline constexpr double reconnect_seconds_max = 30;
inline constexpr std::size_t read_buffer_bytes = 64u << 10;
inline constexpr std::size_t outbox_bytes_max = 16u << 20;  ///< of one connection: beyond it the peer is dropped
inline constexpr std::size_t outbox_bytes_high = 4u << 20;  ///< above it reading pauses
inline constexpr std::size_t outbox_bytes_low = 1u << 20;   ///< below it reading goes on
inline constexpr std::size_t compress_bytes_min = 4'096;    ///< smaller payloads are never compressed
static_assert(heartbeats_per_dead > 2);
static_assert(dead_seconds_max <= lease_seconds);
static_assert(restart_seconds > reconnect_seconds_max + heartbeat_seconds);
static_assert(outbox_bytes_low < outbox_bytes_high);
static_assert(outbox_bytes_high + chunks_in_flight * (frame_header_bytes + frame_payload_bytes_max) <=
              outbox_bytes_max);
static_assert(message_memory_bytes_max >= 2 * frame_payload_bytes_max);
static_assert(flights_per_worker_max * flight_record_bytes <= outbox_bytes_max / 2);

}  // namespace lumenfarm::limits
