/// The client's C ABI, called in any order with right and wrong arguments.
#include "calls.h"

#include <equistream/client.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <string>

namespace equistream::fuzz {

namespace {

int rendered = 0;  ///< times that went well

constexpr int side = 64, max_calls = 40;
constexpr std::size_t room = std::size_t(side) * side * 8 + 64;  ///< of a plane, whatever its format

const std::string& stream() {
    static const std::string file = [] {
        synthetic::Made made = synthetic::small_stream(Codec::h264, true);
        made.pictures = made.settings.pictures = 3;
        made.settings.gop = 2;
        const std::filesystem::path path = scratch_file("called.mkv", {});
        synthetic::write(path, made);
        return path.string();
    }();
    return file;
}

const char* word(Choices& choices) {
    static const std::string endless(70000, 'x');
    const std::array words = {static_cast<const char*>(nullptr),
                              "",
                              "rotation",
                              "mesh",
                              "eye-depth",
                              "none",
                              "pushpull",
                              "hidden,earlier",
                              "gaps",
                              ",,",
                              "\n\x01",
                              endless.c_str()};
    return choices.one_of(words);
}

class Caller {
public:
    explicit Caller(Bytes bytes) : choices_(bytes) {
        request_.struct_size = sizeof request_;
        request_.display_s = 0;
        request_.head.orientation_wxyz[0] = 1;
        request_.width = request_.height = 48;
        checked([&](es_error* error) { return es_client_set_eyes(&request_, 1.5, 0.063, error); });
        usual_ = request_;
    }
    ~Caller() { es_client_close(client_); }
    Caller(const Caller&) = delete;
    Caller& operator=(const Caller&) = delete;

    void run() {
        for (int i = 0; i < max_calls && !choices_.are_over(); ++i)
            call();
    }

private:
    void call() {
        switch (choices_.below(10)) {
        case 0:
            open();
            break;
        case 1:
            es_client_close(std::exchange(client_, nullptr));
            break;
        case 2:
            draw();
            break;
        case 3:
            spoil_request();
            break;
        case 4:
            look();
            break;
        case 5:
            send_head();
            break;
        case 6:
            seek();
            break;
        case 7:
            ask();
            break;
        default:
            render();
        }
    }

    void open() {
        es_client_settings settings{};
        settings.struct_size = sizeof settings;
        settings.abi_version = ES_CLIENT_ABI_VERSION;
        settings.source = stream().c_str();
        settings.software = 1;
        settings.paused = choices_.yes();
        for (int wrong = choices_.below(3); wrong > 0; --wrong)
            spoil(settings);
        es_client* opened = nullptr;
        const es_status status = checked([&](es_error* error) { return es_client_open(&settings, &opened, error); });
        require((status == ES_OK) == (opened != nullptr), "a client comes of a call that went well, and of no other");
        if (opened != nullptr)
            es_client_close(std::exchange(client_, opened));
    }
    void spoil(es_client_settings& settings) {
        switch (choices_.below(11)) {
        case 0:
            settings.struct_size = std::size_t(wrong_count(choices_));
            break;
        case 1:
            settings.abi_version = std::uint32_t(wrong_count(choices_));
            break;
        case 2:
            set_any(choices_, settings.backend);
            break;
        case 3:
            settings.source = word(choices_);
            break;
        case 4:
            settings.engine = word(choices_);
            break;
        case 5:
            settings.fill = word(choices_);
            break;
        case 6:
            settings.mirrors = word(choices_);
            break;
        case 7:
            settings.confidence = 1;
            break;
        case 8:
            settings.loop = 1;
            break;
        case 9:
            settings.max_extrapolation_s = wrong_number(choices_);
            break;
        default:
            settings.exposure_stops = wrong_number(choices_);
        }
    }

    void spoil_request() {
        switch (choices_.below(7)) {
        case 0:
            request_ = usual_;
            break;
        case 1:
            request_.struct_size = std::size_t(wrong_count(choices_));
            break;
        case 2:
            request_.display_s = wrong_number(choices_);
            break;
        case 3:
            fuzz::spoil(choices_, request_.head);
            break;
        case 4:
            fuzz::spoil(choices_, request_.eyes[choices_.below(2)].in_head);
            break;
        case 5: {
            es_field_of_view& fov = request_.eyes[choices_.below(2)].fov;
            (choices_.yes() ? fov.left : fov.up) = wrong_number(choices_);
            break;
        }
        default: {
            const int count = wrong_count(choices_);
            // What is right and large is slow, and shows nothing that the small does not.
            (choices_.yes() ? request_.width : request_.height) = count > side && count <= 16384 ? side : count;
        }
        }
        request_.width = std::min(request_.width, request_.width <= 16384 ? side : request_.width);
    }

    es_eye_image image(std::array<std::vector<std::uint8_t>, 4>& planes) {
        es_eye_image image{};
        image.struct_size = sizeof image;
        if (choices_.yes())
            set_any(choices_, image.format);
        const auto plane = [&](std::size_t i) -> std::uint8_t* {
            planes[i].resize(room);
            return choices_.yes() ? planes[i].data() : nullptr;
        };
        image.pixels = plane(0);
        image.origin = plane(1);
        image.depth_m = reinterpret_cast<float*>(plane(2));
        image.confidence = plane(3);
        if (choices_.below(8) == 0)
            image.struct_size = std::size_t(wrong_count(choices_));
        if (choices_.below(4) == 0)
            image.pixels_stride = std::size_t(choices_.below(2 * side));  // of these none is longer than is room for
        if (choices_.below(4) == 0)
            image.depth_stride = std::size_t(choices_.below(4 * side + 2));
        return image;
    }

    void render() {
        request_.display_s += 0.02;
        std::array<std::vector<std::uint8_t>, 4> left, right;
        es_eye_image images[2] = {image(left), image(right)};
        es_client_state state{};
        state.struct_size = choices_.below(8) == 0 ? std::size_t(wrong_count(choices_)) : sizeof state;
        const es_status status = checked([&](es_error* error) {
            return es_client_render(client_, &request_, images, choices_.yes() ? &state : nullptr, error);
        });
        rendered += status == ES_OK;
        if (status == ES_OK)
            for (const es_eye_image& each : images)
                require(each.width > 0 && each.width <= request_.width && each.height > 0 &&
                            each.height <= request_.height,
                        "a picture has no more pixels than there is room for");
    }
    void draw() {
        es_gl_target targets[2]{};
        targets[0].struct_size = targets[1].struct_size = sizeof targets[0];
        targets[0].x = wrong_count(choices_);
        const es_status status =
            checked([&](es_error* error) { return es_client_draw(client_, &request_, targets, nullptr, error); });
        require(status == ES_BAD_INPUT, "nothing is drawn without OpenGL");
        es_gl_textures textures{};
        textures.struct_size = sizeof textures;
        checked([&](es_error* error) { return es_client_get_textures(client_, &textures, error); });
    }
    void look() {
        es_client_request eyes = usual_;
        const es_status status = checked([&](es_error* error) {
            return es_client_set_eyes(&eyes, wrong_number(choices_), wrong_number(choices_), error);
        });
        if (status == ES_OK)
            request_ = eyes;
    }
    void send_head() {
        es_pose head = usual_.head;
        fuzz::spoil(choices_, head);
        checked([&](es_error* error) { return es_client_send_head(client_, &head, error); });
    }
    void seek() {
        if (client_ != nullptr && choices_.yes())
            choices_.yes() ? es_client_pause(client_) : es_client_play(client_);
        const double time_s = choices_.yes() ? wrong_number(choices_) : choices_.below(8) / 30.0;
        checked([&](es_error* error) { return es_client_seek(client_, time_s, error); });
    }
    void ask() {
        es_client_source source{};
        source.struct_size = choices_.below(4) == 0 ? std::size_t(wrong_count(choices_)) : sizeof source;
        checked([&](es_error* error) { return es_client_get_source(client_, &source, error); });
        es_client_statistics statistics{};
        statistics.struct_size = sizeof statistics;
        checked([&](es_error* error) { return es_client_get_statistics(client_, &statistics, error); });
        if (client_ != nullptr)
            require(es_client_now_s(client_) >= 0, "a clock goes on from 0");
    }

    Choices choices_;
    es_client* client_ = nullptr;
    es_client_request request_{}, usual_{};
};

void read(Bytes bytes) {
    Caller(bytes).run();
}

Seeds seeds() {
    // Each renders by a request as it ought to be first.
    return {{0, 0, 0, 9, 0, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1,
             9, 9, 1, 1, 1, 1, 9, 9, 3, 4, 1, 6, 0, 3, 9, 7, 9, 9, 2, 1, 5},
            {0, 1, 0, 9, 0, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 1,
             1, 0, 1, 1, 7, 9, 9, 6, 0, 2, 9, 4, 2, 3, 9, 8, 1, 0, 0, 9}};
}

}  // namespace

const Target client_calls_target{"client_calls", read, seeds, 40, nullptr, &rendered};

}  // namespace equistream::fuzz
