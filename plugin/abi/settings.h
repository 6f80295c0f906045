#pragma once
/// Checks what a host hands over, field by field; every complaint names the field, what was expected and what was
/// found.
#include "boundary.h"

#include <equistream/cryptomatte.h>
#include <equistream/equistream.h>
#include <equistream/sequence_writer.h>

#include <plugin/denoise/denoiser.h>
#include <plugin/film/film.h>
#include <plugin/film/hidden_layer.h>
#include <plugin/film/rays.h>
#include <plugin/history/history.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace equistream {

/// How a sequence is rendered, which its files do not say.
struct TileSettings {
    bool hidden_layer = false;
    int tile_side = 0;
    bool samples_by_angle = false;
};

/// How a sequence is denoised, by a denoiser of its own; nothing where it is not. Throws InputError.
std::shared_ptr<Denoiser> checked_denoiser(const es_sequence_settings* settings);

/// Throws InputError.
SequenceSettings checked_settings(const es_sequence_settings* settings, const Denoiser* denoiser);
/// What planes of group "cryptomatte" are called by. Throws InputError.
CryptomatteNames checked_names(const es_sequence_settings* settings);
/// Throws InputError.
TileSettings checked_tile_settings(const es_sequence_settings* settings);

struct FrameSettings {
    std::int64_t index = 0;
    double time_s = 0;
    Pose head_previous, head, head_next;
    std::vector<PatchAtlas::Slot> slots;  ///< of an atlas
    std::uint32_t spp = 0;                ///< 0: the sequence's
    std::uint32_t previous_frames = 1;    ///< how many frames ago head_previous is
    WindowPlace window_place{};
    const es_sequence* window = nullptr;  ///< of a base
};

/// Throws InputError.
FrameSettings checked_settings(const es_frame_settings* settings);

// Structs that hosts fill, in every size they have had: a host built with an older header hands over a shorter one.

/// Ascending, today's last. When a field is appended to a struct, that field's offset goes before the last.
inline constexpr std::size_t sequence_settings_sizes[] = {offsetof(es_sequence_settings, geometry_fingerprint),
                                                          offsetof(es_sequence_settings, layer),
                                                          offsetof(es_sequence_settings, patch_side),
                                                          offsetof(es_sequence_settings, denoise),
                                                          offsetof(es_sequence_settings, accumulate_frames),
                                                          offsetof(es_sequence_settings, window_columns),
                                                          offsetof(es_sequence_settings, part_count),
                                                          offsetof(es_sequence_settings, object_names),
                                                          sizeof(es_sequence_settings)};
inline constexpr std::size_t frame_settings_sizes[] = {
    offsetof(es_frame_settings, patches), offsetof(es_frame_settings, spp), offsetof(es_frame_settings, window_x),
    sizeof(es_frame_settings)};
inline constexpr std::size_t plane_sizes[] = {sizeof(es_plane)};

static_assert(sizeof(void*) != 8 ||
                  (sequence_settings_sizes[0] == 176 && frame_settings_sizes[0] == 192 && plane_sizes[0] == 40),
              "the sizes that the first hosts were built with");
static_assert(offsetof(es_sequence_settings, window_columns) % alignof(es_sequence_settings) == 0,
              "the field before it left bytes over in older hosts' structs, which may hold anything");

/// A frame of a sequence of windows, as a base around it sees it.
struct WindowFrame {
    FrameInfo info;
    std::atomic<bool> is_written = false;
};

/// What a frame of a base knows of the window in it.
struct WindowInBase {
    std::shared_ptr<SequenceWriter> sequence;
    std::shared_ptr<const WindowFrame> frame;
    WindowCover cover;
};

/// Of a base's frame, whose window `sequence` is. Throws InputError.
WindowInBase checked_window(const es_sequence& sequence, const FrameInfo& base, bool is_hidden_layer);
/// Of a base: none for tiles that the window covers.
void leave_to_window(const WindowCover& cover, const FrameInfo& base, int tile_side,
                     std::vector<std::uint32_t>& samples);
/// Its finished colours, as they are on the disk, so that a base is the same whichever run rendered the window. Throws
/// InputError where it is not written yet.
FloatImage window_colour(const WindowInBase& window);

}  // namespace equistream

// The opaque handles of equistream.h.

struct es_sequence {
    std::shared_ptr<equistream::SequenceWriter> shared;
    equistream::TileSettings tiles;
    std::shared_ptr<equistream::Denoiser> denoiser;           ///< null where nothing is denoised
    std::shared_ptr<equistream::History> history;             ///< null where frames are independent
    std::shared_ptr<equistream::WindowFrame> window_frame{};  ///< of windows: the frame that was begun last
    std::vector<float> object_ids{}, material_ids{};          ///< FilmSettings'
};

struct es_frame {
    std::shared_ptr<equistream::SequenceWriter> sequence;
    std::shared_ptr<equistream::Denoiser> denoiser;
    std::shared_ptr<equistream::History> history;
    equistream::History::Before before;
    equistream::FrameInfo info;
    equistream::FrameRays rays;
    equistream::Film film;
    std::unique_ptr<equistream::HiddenLayer> hidden;  ///< null in sequences of the first surfaces

    equistream::UsedPixels used_pixels;  ///< of an atlas

    std::shared_ptr<equistream::WindowFrame> as_window;  ///< of a sequence of windows: itself
    std::optional<equistream::WindowInBase> window;      ///< of a base

    /// The first misuse of a call that returns nothing; es_frame_end reports it.
    mutable std::mutex misuse_mutex;
    mutable std::string misuse;
};
