#include "boundary.h"
#include "settings.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/bound.h>
#include <equistream/camera_limits.h>
#include <equistream/text.h>
#include <plugin/film/sampling.h>

#include <algorithm>
#include <cstring>
#include <iterator>

using namespace equistream;

namespace {

FrameInfo frame_info(const SequenceWriter& sequence, const FrameSettings& settings, const Pose& camera) {
    FrameInfo info = sequence.manifest().shared;
    info.index = settings.index;
    info.time_s = settings.time_s;
    info.head = settings.head;
    info.camera_pose = camera;
    if (settings.spp != 0 && settings.spp != info.samples_per_pixel) {
        if (info.accumulated_frames == 0)
            throw InputError(expected_found("es_frame_settings.spp", "0 in a sequence of independent frames",
                                            std::to_string(settings.spp)));
        info.samples_per_pixel = settings.spp;
    }
    if (const auto wrong = position_mismatch(camera.position_m))
        throw InputError(expected_found("es_frame_settings.head: the eye's position", wrong->expected, wrong->found));
    if (info.window_columns > 0) {
        const WindowGrid grid = window_grid_of(info);
        if (const auto problem = window_place_problem(grid, settings.window_place))
            throw InputError("es_frame_settings: " + *problem);
        info.camera = window_camera(grid, settings.window_place);
    } else if (settings.window_place != WindowPlace{}) {
        throw InputError(
            expected_found("es_frame_settings: window_x, window_y", "0 in a sequence that is not of windows",
                           std::to_string(settings.window_place.x) + ", " + std::to_string(settings.window_place.y)));
    }
    if (!info.patches) {
        if (!settings.slots.empty())
            throw InputError(expected_found("patch_count", "0 in a sequence that is no atlas of patches",
                                            std::to_string(settings.slots.size())));
        return info;
    }
    info.patches->slots = settings.slots;
    if (const auto problem = patch_atlas_problem(*info.patches))
        throw InputError("es_frame_settings: patches: " + *problem);
    return info;
}

es_frame* make_frame(const es_sequence& handle, const FrameSettings& settings) {
    const FrameInfo& shared = handle.shared->manifest().shared;
    const auto pose = [&](const Pose& head) {
        return camera_pose(shared.camera, head, shared.eye, shared.ipd_m, shared.lock);
    };
    const FramePoses poses{pose(settings.head_previous), pose(settings.head), pose(settings.head_next)};
    const HeadBox box{poses.here.position_m, head_box_radius(shared.eye, shared.head_radius_m, shared.ipd_m)};
    const FrameInfo info = frame_info(*handle.shared, settings, poses.here);
    std::vector<std::string> planes = handle.shared->manifest().planes;
    for (const char* ours : {"raw", "samples", "variance"})
        std::erase(planes, ours);
    ReferenceTiles references;
    std::erase(planes, "reference_repeat");
    if (std::erase(planes, "reference") > 0)
        references = reference_tiles({picture_width(info), picture_height(info)}, info.samples_per_pixel,
                                     info.accumulated_frames, info.index);
    std::vector<std::uint32_t> tile_samples;
    if (handle.history) {
        for (const std::string& needed : parse_aov_groups(history_aovs))
            if (std::ranges::find(planes, needed) == planes.end())
                planes.push_back(needed);
        tile_samples = handle.history->samples_by_tile(info, handle.tiles.tile_side);
        for (std::uint32_t& samples : tile_samples)
            samples = std::min(samples, geometry_sample - 1);
    }
    if (handle.tiles.samples_by_angle)
        tile_samples =
            samples_by_angle(std::get<EquirectCamera>(info.camera), handle.tiles.tile_side, info.samples_per_pixel);
    std::optional<WindowInBase> window;
    if (settings.window != nullptr) {
        if (handle.shared->part().count > 0)
            throw InputError(expected_found("es_frame_settings.window", "NULL where frames are in parts", "a window"));
        if (std::ranges::find(planes, "crypto_object") != planes.end())
            throw InputError(expected_found("es_frame_settings.window", "NULL with group cryptomatte", "a window"));
        window = checked_window(*settings.window, info, handle.tiles.hidden_layer);
        if (!handle.history) {  // what is carried on is better rendered than 0
            if (tile_samples.empty())
                tile_samples.assign(tile_count(info, handle.tiles.tile_side), info.samples_per_pixel);
            leave_to_window(window->cover, info, handle.tiles.tile_side, tile_samples);
        }
    }
    std::shared_ptr<WindowFrame> as_window;
    if (info.window_columns > 0) {
        as_window = std::make_shared<WindowFrame>();
        as_window->info = info;
    }
    const bool guides = handle.denoiser != nullptr || std::ranges::find(planes, "guide_albedo") != planes.end();
    return new es_frame{handle.shared,
                        handle.denoiser,
                        handle.history,
                        {settings.index - std::int64_t{settings.previous_frames}, poses.previous},
                        info,
                        FrameRays(info),
                        Film(info, poses,
                             {info.samples_per_pixel, planes, std::move(tile_samples), handle.history != nullptr,
                              guides, handle.tiles.tile_side, handle.tiles.hidden_layer || info.patches,
                              std::move(references), handle.object_ids, handle.material_ids, handle.shared->part()}),
                        handle.tiles.hidden_layer ? std::make_unique<HiddenLayer>(box) : nullptr,
                        {},
                        std::move(as_window),
                        std::move(window),
                        {},
                        {}};
}

/// Of frames that are put together: takes what all parts brought.
void put_parts(es_frame& frame) {
    const SequenceWriter& sequence = *frame.sequence;
    for (std::uint32_t number = 1; number <= sequence.part().count; ++number) {
        const FramePart part{number, sequence.part().count};
        frame.film.put_part(part, sequence.read_part(frame.info.index, number, frame.film.part_size(part)));
    }
}

void keep_misuse(const es_frame* frame, const std::string& problem) {
    const std::lock_guard lock(frame->misuse_mutex);
    if (frame->misuse.empty())
        frame->misuse = problem;
}

/// True when a tile call may go on; otherwise the misuse is kept for es_frame_end.
bool usable(const es_frame* frame, const es_tile* tile, const void* data, const char* call) {
    if (frame == nullptr)
        return false;
    std::string problem;
    if (tile == nullptr || data == nullptr)
        problem = expected_found(call, "pointers", "NULL");
    else if (!frame->film.knows(*tile))
        problem = expected_found(call, "a tile of this frame, unchanged", "tile " + std::to_string(tile->id));
    if (problem.empty())
        return true;
    keep_misuse(frame, problem);
    return false;
}

/// Pixels that answers are of. Those of a hidden layer are known once it has been searched; until then there are none,
/// and asking for them is a misuse.
TilePixels pixels_of(const es_frame& frame, const es_tile& tile, const char* call) {
    static const std::vector<std::uint32_t> none;
    if (frame.info.patches)
        return {tile, &frame.used_pixels.of(tile, *frame.info.patches)};
    if (!frame.hidden)
        return {tile};
    const HiddenLayer::Found* found = frame.hidden->found(tile);
    if (found == nullptr)
        keep_misuse(&frame,
                    expected_found(call, "a tile whose probe rays are answered", "tile " + std::to_string(tile.id)));
    return {tile, found == nullptr ? &none : &found->pixels};
}

template <typename MakeRay>
std::uint32_t fill_rays(const es_frame& frame, const TilePixels& pixels, es_ray* rays, MakeRay make_ray) {
    const HiddenLayer::Found* const found = frame.hidden ? frame.hidden->found(pixels.tile) : nullptr;
    for (std::uint32_t i = 0; i < pixels.count(); ++i) {
        const auto at = pixels.at(i);
        rays[i] = make_ray(at.x, at.y);
        rays[i].pixel = pixels.listed == nullptr ? i : (*pixels.listed)[i];
        if (found != nullptr)
            rays[i].t_min = found->begin_m[i];
    }
    return pixels.count();
}

AovInfo checked_plane(const es_frame& frame, const es_plane& plane) {
    if (plane.name == nullptr || plane.data == nullptr)
        throw InputError(expected_found("es_plane", "a name and data", "NULL"));
    if (!frame.film.wants(plane.name))
        throw InputError(expected_found("es_plane.name", "one of " + in_a_sentence(frame.film.planes(), ", "),
                                        "\"" + std::string(plane.name) + "\""));
    const AovInfo aov = *find_aov(plane.name);
    const std::string where = "plane " + std::string(aov.name);
    const bool is_id = aov.type == SampleType::id;
    int type = 0;
    std::memcpy(&type, &plane.type, sizeof type);
    if (type != (is_id ? ES_UINT32 : ES_FLOAT32))
        throw InputError(expected_found(where + ": type", is_id ? "ES_UINT32" : "ES_FLOAT32", std::to_string(type)));
    if (plane.channels != static_cast<int>(aov.channels.size()))
        throw InputError(
            expected_found(where + ": channels", std::to_string(aov.channels.size()), std::to_string(plane.channels)));
    const std::size_t row_bytes = static_cast<std::size_t>(picture_width(frame.info)) * aov.channels.size() * 4;
    if (plane.row_stride_bytes < row_bytes)
        throw InputError(expected_found(where + ": row_stride_bytes", "at least " + std::to_string(row_bytes),
                                        std::to_string(plane.row_stride_bytes)));
    return aov;
}

template <typename T>
Image<T> copied(const es_plane& plane, int width, int height) {
    Image<T> image(width, height, plane.channels);
    const std::size_t row_bytes =
        static_cast<std::size_t>(width) * static_cast<std::size_t>(plane.channels) * sizeof(T);
    const char* row = static_cast<const char*>(plane.data);
    for (int y = 0; y < height; ++y, row += plane.row_stride_bytes)
        std::memcpy(image.pixel(0, y), row, row_bytes);
    return image;
}

/// What is not asked for goes.
void accumulate(const es_frame& frame, Frame& finished) {
    frame.history->accumulate(finished, frame.before);
    const std::vector<std::string>& planes = frame.sequence->manifest().planes;
    const auto is_unwanted = [&](const auto& plane) { return std::ranges::find(planes, plane.first) == planes.end(); };
    std::erase_if(finished.planes, is_unwanted);
    std::erase_if(finished.ids, is_unwanted);
}

/// What is not asked for goes; pixels that nobody answered for are padded anew.
void denoise(const es_frame& frame, Frame& finished) {
    const std::vector<std::string>& planes = frame.sequence->manifest().planes;
    const auto is_wanted = [&](const char* name) { return std::ranges::find(planes, name) != planes.end(); };
    FloatImage& colour = finished.planes.at("colour");
    if (is_wanted("raw") || frame.history) {
        FloatImage raw(colour.width(), colour.height(), 3);
        for (int y = 0; y < raw.height(); ++y)
            for (int x = 0; x < raw.width(); ++x)
                std::copy_n(colour.pixel(x, y), 3, raw.pixel(x, y));
        finished.planes["raw"] = std::move(raw);
    }
    frame.denoiser->denoise(finished);
    for (const char* guide : {"guide_albedo", "guide_normal"})
        if (!is_wanted(guide))
            finished.planes.erase(guide);
    if (const ByteImage* answered = frame.film.padded())
        pad_colour(colour, *answered, columns_close(frame.info.camera) && !frame.info.patches);
}

}  // namespace

extern "C" {

es_status es_frame_begin(es_sequence* sequence, const es_frame_settings* settings, es_frame** frame, es_error* error) {
    if (frame != nullptr)
        *frame = nullptr;
    return guarded(error, [&] {
        if (sequence == nullptr || frame == nullptr)
            throw InputError(expected_found("es_frame_begin", "pointers", "NULL"));
        std::unique_ptr<es_frame> made(make_frame(*sequence, checked_settings(settings)));
        if (sequence->shared->part().is_put_together())
            put_parts(*made);
        *frame = made.release();
        sequence->window_frame = (*frame)->as_window;
    });
}

es_status es_frame_next_tile(es_frame* frame, es_tile* tile) {
    if (frame == nullptr || tile == nullptr)
        return ES_BAD_INPUT;
    bool more = false;
    const es_status status = guarded(nullptr, [&] {
        if (const auto next = frame->film.next_tile()) {
            *tile = *next;
            more = true;
        }
    });
    return status != ES_OK ? status : more ? ES_OK : ES_DONE;
}

uint32_t es_tile_probe_rays(es_frame* frame, const es_tile* tile, es_ray* rays) {
    std::uint32_t count = 0;
    guarded(nullptr, [&] {
        if (usable(frame, tile, rays, "es_tile_probe_rays") && frame->hidden)
            count = frame->hidden->ask(*tile, frame->rays, rays);
    });
    return count;
}

void es_tile_put_distances(es_frame* frame, const es_tile* tile, const float* distances_m) {
    guarded(nullptr, [&] {
        if (!usable(frame, tile, distances_m, "es_tile_put_distances"))
            return;
        if (!frame->hidden || !frame->hidden->tell(*tile, frame->rays, distances_m))
            keep_misuse(frame, expected_found("es_tile_put_distances", "answers to es_tile_probe_rays",
                                              "none asked for in tile " + std::to_string(tile->id)));
    });
}

uint32_t es_tile_geometry_rays(const es_frame* frame, const es_tile* tile, es_ray* rays) {
    std::uint32_t count = 0;
    guarded(nullptr, [&] {
        if (usable(frame, tile, rays, "es_tile_geometry_rays") && !frame->film.is_reference(tile->id))
            count = fill_rays(*frame, pixels_of(*frame, *tile, "es_tile_geometry_rays"), rays,
                              [&](int x, int y) { return frame->rays.geometry(x, y); });
    });
    return count;
}

uint32_t es_tile_colour_rays(const es_frame* frame, const es_tile* tile, uint32_t sample, es_ray* rays) {
    std::uint32_t count = 0;
    guarded(nullptr, [&] {
        if (!usable(frame, tile, rays, "es_tile_colour_rays"))
            return;
        if (sample >= frame->film.passes_of(tile->id))
            keep_misuse(frame, expected_found("es_tile_colour_rays: sample",
                                              "below " + std::to_string(frame->film.passes_of(tile->id)),
                                              std::to_string(sample)));
        else
            count = fill_rays(*frame, pixels_of(*frame, *tile, "es_tile_colour_rays"), rays,
                              [&, number = frame->film.sample_number(tile->id, sample)](int x, int y) {
                                  return frame->rays.colour(x, y, number);
                              });
    });
    return count;
}

void es_tile_put_surfaces(es_frame* frame, const es_tile* tile, const es_surface* surfaces) {
    guarded(nullptr, [&] {
        if (usable(frame, tile, surfaces, "es_tile_put_surfaces"))
            frame->film.put_surfaces(pixels_of(*frame, *tile, "es_tile_put_surfaces"), surfaces);
    });
}

void es_tile_put_radiance(es_frame* frame, const es_tile* tile, const float* rgba) {
    guarded(nullptr, [&] {
        if (usable(frame, tile, rgba, "es_tile_put_radiance") &&
            !frame->film.add_radiance(pixels_of(*frame, *tile, "es_tile_put_radiance"), rgba))
            keep_misuse(frame, expected_found("es_tile_put_radiance: tile " + std::to_string(tile->id),
                                              std::to_string(frame->film.passes_of(tile->id)) + " passes", "one more"));
    });
}

void es_tile_put_guides(es_frame* frame, const es_tile* tile, const float* guides) {
    guarded(nullptr, [&] {
        if (usable(frame, tile, guides, "es_tile_put_guides") && frame->film.takes_guides() &&
            !frame->film.add_guides(pixels_of(*frame, *tile, "es_tile_put_guides"), guides))
            keep_misuse(frame, expected_found("es_tile_put_guides: tile " + std::to_string(tile->id),
                                              std::to_string(frame->film.passes_of(tile->id)) + " passes", "one more"));
    });
}

void es_tile_put_ids(es_frame* frame, const es_tile* tile, const uint32_t* ids) {
    guarded(nullptr, [&] {
        if (usable(frame, tile, ids, "es_tile_put_ids") && frame->film.takes_ids() &&
            !frame->film.add_ids(pixels_of(*frame, *tile, "es_tile_put_ids"), ids))
            keep_misuse(frame, expected_found("es_tile_put_ids: tile " + std::to_string(tile->id),
                                              std::to_string(frame->film.passes_of(tile->id)) + " passes", "one more"));
    });
}

es_status es_frame_put_plane(es_frame* frame, const es_plane* plane, es_error* error) {
    return guarded(error, [&] {
        if (frame == nullptr || plane == nullptr)
            throw InputError(expected_found("es_frame_put_plane", "pointers", "NULL"));
        const es_plane whole = whole_struct(plane, "es_plane", plane_sizes);
        const AovInfo aov = checked_plane(*frame, whole);
        if (frame->sequence->part().count > 0)
            throw InputError(expected_found("es_frame_put_plane", "planes given tile by tile, as frames are in parts",
                                            "the whole plane " + std::string(whole.name)));
        const int width = picture_width(frame->info);
        const int height = picture_height(frame->info);
        if (aov.type == SampleType::id) {
            frame->film.put_plane(whole.name, copied<std::uint32_t>(whole, width, height));
            return;
        }
        FloatImage image = copied<float>(whole, width, height);
        require_plane_values(aov, image.view());
        frame->film.put_plane(whole.name, std::move(image));
    });
}

es_status es_frame_end(es_frame* frame, es_error* error) {
    const std::unique_ptr<es_frame> owned(frame);
    return guarded(error, [&] {
        if (frame == nullptr)
            throw InputError(expected_found("es_frame_end: frame", "a pointer", "NULL"));
        const std::string where = "frame " + std::to_string(frame->info.index);
        if (!frame->misuse.empty())
            throw InputError(where + ": " + frame->misuse);
        if (const auto missing = frame->film.missing())
            throw InputError(expected_found(where, "every plane finished", *missing));
        if (frame->sequence->part().is_one())
            return frame->sequence->write_part(frame->info, frame->film.part_bytes());
        Frame finished;
        finished.info = frame->info;
        frame->film.finish(finished);
        const FloatImage window = frame->window ? window_colour(*frame->window) : FloatImage();
        const auto show_window = [&] {
            if (frame->window)
                frame->window->cover.put(window.view(), finished.planes.at("colour").view());
        };
        if (!frame->history)  // a denoiser looks across the window's border
            show_window();
        if (frame->denoiser)
            denoise(*frame, finished);
        if (frame->history)
            accumulate(*frame, finished);
        try {
            show_window();
            frame->sequence->write(finished, frame->film.left_out_samples());
        } catch (...) {
            if (frame->history)
                frame->history->take_back();
            throw;
        }
        if (frame->sequence->part().is_put_together())
            frame->sequence->remove_parts(frame->info.index);
        if (frame->as_window)
            frame->as_window->is_written = true;
    });
}

void es_frame_discard(es_frame* frame) {
    delete frame;
}

uint32_t es_abi_version(void) {
    return ES_ABI_VERSION;
}

const char* es_version(void) {
    return EQUISTREAM_VERSION;
}

es_status es_sequence_open(const es_sequence_settings* settings, es_sequence** sequence, es_error* error) {
    if (sequence != nullptr)
        *sequence = nullptr;
    return guarded(error, [&] {
        if (sequence == nullptr)
            throw InputError(expected_found("es_sequence_open: sequence", "a pointer", "NULL"));
        std::shared_ptr<Denoiser> denoiser = checked_denoiser(settings);
        *sequence = new es_sequence{std::make_shared<SequenceWriter>(checked_settings(settings, denoiser.get())),
                                    checked_tile_settings(settings), std::move(denoiser), nullptr};
        const CryptomatteNames names = checked_names(settings);
        std::ranges::transform(names.objects, std::back_inserter((*sequence)->object_ids), cryptomatte_id);
        std::ranges::transform(names.materials, std::back_inserter((*sequence)->material_ids), cryptomatte_id);
        if (const std::uint32_t frames = (*sequence)->shared->manifest().shared.accumulated_frames; frames > 0)
            (*sequence)->history = std::make_shared<History>(frames);
    });
}

int es_sequence_has_frame(const es_sequence* sequence, int64_t index) {
    bool kept = false;
    if (sequence != nullptr)
        guarded(nullptr, [&] { kept = sequence->shared->keeps_frame(index); });
    return kept;
}

void es_sequence_close(es_sequence* sequence) {
    delete sequence;
}

}  // extern "C"
