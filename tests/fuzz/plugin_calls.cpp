/// The plugin's C ABI, called in any order with right and wrong arguments.
#include "calls.h"

#include <equistream/equistream.h>

#include <string>
#include <utility>

namespace equistream::fuzz {

namespace {

int ended_frames = 0;

constexpr int side = 64, max_calls = 120;
constexpr std::size_t room = std::size_t(side) * side;  ///< of rays: no tile has more pixels than the frame

const char* word(Choices& choices) {
    static const std::string endless(70000, 'x');
    const std::array words = {static_cast<const char*>(nullptr),
                              "",
                              "none",
                              "all",
                              "depth,motion",
                              "nothing",
                              "\n\x01",
                              "\xff\xfe",
                              endless.c_str()};
    return choices.one_of(words);
}

class Host {
public:
    explicit Host(Bytes bytes)
        : choices_(bytes), folder_((scratch_file("called", {}).parent_path() / "called_out").string()) {}
    ~Host() {
        es_frame_discard(frame_);
        es_sequence_close(sequence_);
        es_sequence_close(windows_);
        std::filesystem::remove_all(folder_);
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    void run() {
        for (int i = 0; i < max_calls && !choices_.are_over(); ++i)
            call();
    }

private:
    void call() {
        const int which = choices_.below(16);
        switch (which) {
        case 0:
            open();
            break;
        case 1:
        case 13:
            begin(which == 13 ? windows_ : sequence_);
            break;
        case 2:
            next_tile();
            break;
        case 3:
            geometry();
            break;
        case 4:
            colour();
            break;
        case 5:
            plane();
            break;
        case 6:
            end();
            break;
        case 7:
            es_frame_discard(std::exchange(frame_, nullptr));
            break;
        case 8:
            probe();
            break;
        case 9:
            all_tiles();
            break;
        case 10:
            tile_.id = std::uint32_t(wrong_count(choices_));
            tile_.sample_count = 3;
            break;
        case 11:
            es_sequence_has_frame(sequence_, wrong_count(choices_));
            break;
        case 12:
            open_kind();
            break;
        default:
            require(es_abi_version() == ES_ABI_VERSION && *es_version() != '\0', "a library knows its version");
            begin(which == 14 ? windows_ : sequence_);
            all_tiles();
            end();
        }
    }

    es_sequence_settings usual() const {
        es_sequence_settings settings{};
        settings.struct_size = sizeof settings;
        settings.abi_version = ES_ABI_VERSION;
        settings.spp = 1;
        settings.camera = ES_EQUIRECT;
        settings.width = 32;
        settings.height = 16;
        settings.fov_x_rad = 1.5;
        settings.ipd_m = 0.063;
        settings.frames_per_second = 30;
        settings.exposure = 1;
        settings.output_dir = folder_.c_str();
        settings.aovs = "all";
        settings.scene_name = "scene";
        settings.host_name = "host";
        return settings;
    }
    void open() {
        es_sequence_settings settings = usual();
        settings.camera = choices_.yes() ? ES_EQUIRECT : ES_PERSPECTIVE;
        settings.overwrite = choices_.yes();
        settings.layer = choices_.below(8) == 0 ? ES_LAYER_HIDDEN : ES_LAYER_FIRST;
        const double offset_m[3] = {0.03, 0, wrong_number(choices_)};
        settings.patch_offsets_m = offset_m;
        const char* const names[] = {"a", "\xff", nullptr};
        if (settings.layer == ES_LAYER_FIRST && choices_.yes()) {
            settings.aovs = "all,cryptomatte";
            settings.object_names = names;
            settings.object_name_count = std::uint32_t(choices_.below(4));
        }
        for (int wrong = choices_.below(4); wrong > 0; --wrong)
            spoil(settings);
        // What is right and large is slow, and shows nothing that the small does not.
        if (std::int64_t(settings.width) * settings.height > std::int64_t(room) && settings.width > 0 &&
            settings.width <= 32768 && settings.height <= 32768)
            settings.width = settings.height = side;
        open(settings, sequence_);
    }
    /// An atlas, a sequence of windows, or frames that are accumulated or denoised.
    void open_kind() {
        es_sequence_settings settings = usual();
        settings.overwrite = 1;
        const double offset_m[3] = {0.03, 0, 0};
        const std::string windows = folder_ + "/windows";
        const int kind = choices_.below(5);
        if (kind == 0) {
            settings.aovs = "depth,normal";
            settings.patch_side = 8;
            settings.patch_columns = settings.patch_rows = 2;
            settings.patch_offset_count = 1;
            settings.patch_offsets_m = offset_m;
        } else if (kind == 1) {
            settings.window_columns = 64;
            settings.output_dir = windows.c_str();
        } else if (kind == 2) {
            settings.accumulate_frames = 4;
            settings.aovs = choices_.yes() ? "samples,variance" : "all";
        } else {
            settings.denoise = ES_DENOISE_FAST;
            settings.denoise_threads = 1;
            settings.accumulate_frames = kind == 3 ? 0 : 4;
            settings.aovs = choices_.yes() ? "all,raw" : "none";
        }
        open(settings, kind == 1 ? windows_ : sequence_);
    }
    void open(const es_sequence_settings& settings, es_sequence*& sequence) {
        es_sequence* opened = nullptr;
        const es_status status = checked([&](es_error* error) { return es_sequence_open(&settings, &opened, error); });
        require((status == ES_OK) == (opened != nullptr), "a sequence comes of a call that went well, and of no other");
        if (opened == nullptr)
            return;
        es_frame_discard(std::exchange(frame_, nullptr));
        es_sequence_close(std::exchange(sequence, opened));
    }
    void spoil(es_sequence_settings& settings) {
        switch (choices_.below(23)) {
        case 0:
            settings.struct_size = std::size_t(wrong_count(choices_));
            break;
        case 1:
            settings.abi_version = std::uint32_t(wrong_count(choices_));
            break;
        case 2:
            settings.spp = std::uint32_t(choices_.below(8));
            break;
        case 3:
            set_any(choices_, settings.camera);
            break;
        case 4:
            settings.width = wrong_count(choices_);
            break;
        case 5:
            settings.height = wrong_count(choices_);
            break;
        case 6:
            settings.fov_x_rad = wrong_number(choices_);
            break;
        case 7:
            settings.longitude_min = wrong_number(choices_);
            break;
        case 8:
            settings.latitude_max = wrong_number(choices_);
            break;
        case 9:
            set_any(choices_, settings.eye);
            break;
        case 10:
            set_any(choices_, settings.lock);
            break;
        case 11:
            settings.frames_per_second = wrong_number(choices_);
            break;
        case 12:
            settings.exposure = wrong_number(choices_);
            break;
        case 13:
            settings.aovs = word(choices_);
            break;
        case 14:
            settings.scene_name = word(choices_);
            break;
        case 15:
            settings.fingerprint = word(choices_);
            break;
        case 16:
            settings.tile_side = wrong_count(choices_);
            break;
        case 17:
            set_any(choices_, settings.layer);
            break;
        case 18:
            settings.accumulate_frames = std::uint32_t(wrong_count(choices_));
            break;
        case 19:
            settings.window_columns = wrong_count(choices_);
            settings.width = settings.height = 16;
            break;
        case 20:
            settings.samples_by_angle = 1;
            break;
        case 21:
            settings.part_count = std::uint32_t(choices_.below(4));
            settings.part = std::uint32_t(choices_.below(4));
            break;
        default:
            settings.patch_side = 4;
            settings.patch_columns = choices_.yes() ? 2 : wrong_count(choices_);
            settings.patch_rows = 2;
            settings.patch_offset_count = 1;
        }
    }

    void begin(es_sequence* sequence) {
        es_frame_settings when{};
        when.struct_size = sizeof when;
        when.index = choices_.below(4);
        for (es_pose* pose : {&when.head_previous, &when.head, &when.head_next})
            pose->orientation_wxyz[0] = 1;
        const es_patch patches[4] = {
            {1, 0, 1, 1}, {choices_.below(2), std::uint32_t(choices_.below(3)), 200, 0}, {}, {}};
        when.patches = patches;
        when.patch_count = choices_.yes() ? 4 : 0;
        switch (choices_.below(16)) {
        case 0:
            when.struct_size = std::size_t(wrong_count(choices_));
            break;
        case 1:
            when.index = wrong_count(choices_);
            break;
        case 2:
            when.time_s = wrong_number(choices_);
            break;
        case 3:
            fuzz::spoil(choices_, when.head);
            break;
        case 4:
            fuzz::spoil(choices_, when.head_previous);
            break;
        case 5:
            when.window_x = wrong_count(choices_);
            break;
        case 6:
            when.window_y = wrong_count(choices_);
            break;
        case 7:
            when.window = choices_.yes() ? sequence_ : windows_;
            break;
        case 8:
            when.previous_frames = std::uint32_t(wrong_count(choices_));
            break;
        case 9:
            when.spp = std::uint32_t(choices_.below(4));
            break;
        case 10:
            when.window_x = 16 * choices_.below(4);
            break;
        }
        if (frame_ != nullptr && choices_.yes())
            es_frame_discard(std::exchange(frame_, nullptr));
        es_frame* begun = nullptr;
        const es_status status =
            checked([&](es_error* error) { return es_frame_begin(sequence, &when, &begun, error); });
        require((status == ES_OK) == (begun != nullptr), "a frame comes of a call that went well, and of no other");
        if (begun != nullptr)
            es_frame_discard(std::exchange(frame_, begun));
    }

    bool next_tile() {
        es_tile tile{};
        const es_status status = es_frame_next_tile(frame_, &tile);
        require(status == ES_OK || status == ES_DONE || frame_ == nullptr, "tiles come until they are done");
        if (status != ES_OK)
            return false;
        require(tile.pixel_count <= room, "a tile lies in its frame");
        tile_ = tile;
        return true;
    }
    void probe() {
        for (int round = 0; round < 100; ++round) {
            const std::uint32_t count = es_tile_probe_rays(frame_, &tile_, rays_.data());
            require(count <= room, "no more rays than pixels");
            if (count == 0)
                return;
            distances_.assign(count, choices_.yes() ? 2.0f : float(wrong_number(choices_)));
            es_tile_put_distances(frame_, &tile_, distances_.data());
        }
    }
    void geometry() {
        const std::uint32_t count = es_tile_geometry_rays(frame_, &tile_, rays_.data());
        require(count <= room, "no more rays than pixels");
        es_surface surface{};
        surface.distance_m = choices_.yes() ? 2.0f : float(wrong_number(choices_));
        surface.normal[choices_.below(3)] = float(wrong_number(choices_));
        surface.position_previous_m[0] = float(wrong_number(choices_));
        surface.virtual_distance_m = float(wrong_number(choices_));
        std::fill(surfaces_.begin(), surfaces_.end(), surface);
        es_tile_put_surfaces(frame_, &tile_, surfaces_.data());
    }
    void colour() {
        const std::uint32_t count = es_tile_colour_rays(frame_, &tile_, std::uint32_t(choices_.below(3)), rays_.data());
        require(count <= room, "no more rays than pixels");
        std::fill(rgba_.begin(), rgba_.end(), choices_.yes() ? 0.5f : float(wrong_number(choices_)));
        es_tile_put_radiance(frame_, &tile_, rgba_.data());
        if (choices_.yes())
            es_tile_put_guides(frame_, &tile_, guides_.data());
        const std::vector<std::uint32_t> ids(2 * room, std::uint32_t(wrong_count(choices_)));
        es_tile_put_ids(frame_, &tile_, ids.data());
    }
    void all_tiles() {
        while (next_tile()) {
            probe();
            geometry();
            for (std::uint32_t pass = 0; pass < tile_.sample_count; ++pass) {
                es_tile_colour_rays(frame_, &tile_, pass, rays_.data());
                es_tile_put_radiance(frame_, &tile_, rgba_.data());
                es_tile_put_ids(frame_, &tile_, std::vector<std::uint32_t>(2 * room, pass).data());
            }
        }
    }
    void plane() {
        constexpr std::array names = {"colour", "depth", "backward", "object_id", "normal", "variance", "nothing", ""};
        es_plane plane{};
        plane.struct_size = choices_.below(8) == 0 ? std::size_t(wrong_count(choices_)) : sizeof plane;
        plane.name = choices_.below(8) == 0 ? nullptr : choices_.one_of(names);
        set_any(choices_, plane.type);
        plane.channels = choices_.yes() ? choices_.below(5) : wrong_count(choices_);
        // As long as a row of any picture here, or shorter than is allowed.
        plane.row_stride_bytes = choices_.yes() ? std::size_t(side) * 16 : std::size_t(choices_.below(64));
        planes_.assign(room * 16, std::uint8_t(choices_.below(256)));
        plane.data = choices_.below(8) == 0 ? nullptr : planes_.data();
        checked([&](es_error* error) { return es_frame_put_plane(frame_, &plane, error); });
    }
    void end() {
        es_frame* const frame = std::exchange(frame_, nullptr);
        if (checked([&](es_error* error) { return es_frame_end(frame, error); }) == ES_OK)
            ++ended_frames;
    }

    Choices choices_;
    std::string folder_;
    es_sequence *sequence_ = nullptr, *windows_ = nullptr;
    es_frame* frame_ = nullptr;
    es_tile tile_{};
    std::vector<es_ray> rays_{room};
    std::vector<es_surface> surfaces_{room};
    std::vector<float> rgba_ = std::vector<float>(room * 4), guides_ = std::vector<float>(room * 6), distances_;
    std::vector<std::uint8_t> planes_;
};

void read(Bytes bytes) {
    Host(bytes).run();
}

Seeds seeds() {
    // Opens a sequence, begins a frame, answers all tiles and ends it, twice; then hands over a plane in place of
    // tiles.
    return {{0, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 15, 9, 1, 0, 0, 0, 0, 6, 1, 1, 0, 0, 0, 15, 9, 1, 0, 0, 0, 0, 6},
            {0, 1, 1, 1, 0, 0, 1, 13, 2, 1, 0, 0, 0, 0, 15, 5, 1, 1, 0, 1, 0, 1, 4, 1, 0, 1, 6},
            // A window and the base around it.
            {0, 0, 1, 1, 0, 0, 0, 12, 1, 14, 0, 1, 0, 0, 10, 0, 0, 15, 0, 1, 0, 0, 7, 0, 0},
            // An atlas; frames that are accumulated; frames that are denoised.
            {12, 0, 15, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1},
            {12, 2, 1, 15, 0, 0, 0, 0, 15, 0, 15, 1, 0, 0, 0, 9, 2, 0},
            {12, 3, 1, 15, 0, 0, 0, 0, 15, 0},
            {12, 4, 0, 15, 0, 0, 0, 0, 15, 0, 15, 1, 0, 0, 0, 15, 0}};
}

}  // namespace

const Target plugin_calls_target{"plugin_calls", read, seeds, 60, nullptr, &ended_frames};

}  // namespace equistream::fuzz
