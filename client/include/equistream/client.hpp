#ifndef EQUISTREAM_CLIENT_HPP
#define EQUISTREAM_CLIENT_HPP
/// client.h for C++17: one class that closes itself, and errors that are thrown. Header only; nothing else is linked
/// than libequistream_client. client.h states conventions, threading and ownership.
#include <equistream/client.h>

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

/// A call failed. `is_input`: an argument was wrong, and nothing was done. `shown`: a render or draw could not show the
/// frame that was due, and has shown the one before it; this is its state.
class ClientError : public std::runtime_error {
public:
    ClientError(es_status status, const es_error& error, std::optional<es_client_state> state = std::nullopt)
        : std::runtime_error(error.text), is_input(status == ES_BAD_INPUT), shown(state) {}
    const bool is_input;
    const std::optional<es_client_state> shown;
};

/// Settings with their size and version set. All other fields are 0: the defaults.
inline es_client_settings client_settings(const char* source, es_backend backend = ES_BACKEND_CPU) {
    es_client_settings settings{};
    settings.struct_size = sizeof settings;
    settings.abi_version = ES_CLIENT_ABI_VERSION;
    settings.backend = backend;
    settings.source = source;
    return settings;
}

/// One eye's picture in memory of its own.
struct ClientPicture {
    int width = 0, height = 0;
    es_field_of_view fov{};
    std::vector<std::uint8_t> rgba;        ///< 4 a pixel, rows from the top
    std::vector<std::uint8_t> origin;      ///< es_origin
    std::vector<float> depth_m;            ///< metres along each ray; +inf: no surface; NaN: unknown
    std::vector<std::uint8_t> confidence;  ///< 255 times a probability; 0 unless opened with confidence
};

/// One open source. With ES_BACKEND_OPENGL its context is current in the constructor, the destructor and every call.
class Client {
public:
    /// Throws ClientError, or std::runtime_error if the library has another ABI version than this header.
    explicit Client(const es_client_settings& settings) {
        if (es_client_abi_version() != ES_CLIENT_ABI_VERSION)
            throw std::runtime_error("libequistream_client: expected ABI version " +
                                     std::to_string(ES_CLIENT_ABI_VERSION) + ", found " +
                                     std::to_string(es_client_abi_version()));
        check([&](es_error* error) { return es_client_open(&settings, &client_, error); });
    }
    explicit Client(const char* source, es_backend backend = ES_BACKEND_CPU)
        : Client(client_settings(source, backend)) {}
    ~Client() { es_client_close(client_); }
    Client(Client&& other) noexcept : client_(std::exchange(other.client_, nullptr)) {}
    Client& operator=(Client&& other) noexcept {
        std::swap(client_, other.client_);
        return *this;
    }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    es_client_source source() const { return filled<es_client_source>(es_client_get_source); }
    double now_s() const { return es_client_now_s(client_); }

    /// An ordinary display's request: the head of the first frame, its distance between the eyes, the time now.
    es_client_request request(int width, int height, double fov_x_rad) const {
        const es_client_source opened = source();
        es_client_request request = empty<es_client_request>();
        request.display_s = now_s();
        request.head = opened.first_head;
        request.width = width;
        request.height = height;
        check([&](es_error* error) { return es_client_set_eyes(&request, fov_x_rad, opened.ipd_m, error); });
        return request;
    }

    /// Where this throws, `eyes` hold the pictures that ClientError::shown describes. Without it they are empty.
    es_client_state render(const es_client_request& request, ClientPicture (&eyes)[2]) {
        es_eye_image images[2] = {};
        const std::size_t pixels = pixels_of(request);
        for (int i = 0; i < 2; ++i) {
            eyes[i].rgba.resize(4 * pixels);
            eyes[i].origin.resize(pixels);
            eyes[i].depth_m.resize(pixels);
            eyes[i].confidence.resize(pixels);
            images[i].pixels = eyes[i].rgba.data();
            images[i].origin = eyes[i].origin.data();
            images[i].depth_m = eyes[i].depth_m.data();
            images[i].confidence = eyes[i].confidence.data();
        }
        const Shown shown = render_into(request, images);
        for (int i = 0; i < 2; ++i)
            keep(images[i], request.width, eyes[i]);
        return shown.checked();
    }
    /// Renders into the caller's memory. Sets each struct_size.
    es_client_state render(const es_client_request& request, es_eye_image (&images)[2]) {
        return render_into(request, images).checked();
    }
    es_client_state draw(const es_client_request& request, es_gl_target (&targets)[2]) {
        const Shown shown = shown_in(targets, [&](es_client_state* state, es_error* error) {
            return es_client_draw(client_, &request, targets, state, error);
        });
        return shown.checked();
    }
    es_gl_textures textures() { return filled<es_gl_textures>(es_client_get_textures); }

    void send_head(const es_pose& head) {
        check([&](es_error* error) { return es_client_send_head(client_, &head, error); });
    }
    void pause() { es_client_pause(client_); }
    void play() { es_client_play(client_); }
    void seek(double time_s) {
        check([&](es_error* error) { return es_client_seek(client_, time_s, error); });
    }
    es_client_statistics statistics() const { return filled<es_client_statistics>(es_client_get_statistics); }

private:
    /// What became of a render or draw.
    struct Shown {
        es_status status = ES_OK;
        es_error error{};
        es_client_state state = empty<es_client_state>();
        bool is_there = false;  ///< pictures, and `state`

        es_client_state checked() const {
            if (status != ES_OK)
                throw ClientError(status, error, is_there ? std::optional(state) : std::nullopt);
            return state;
        }
    };

    Shown render_into(const es_client_request& request, es_eye_image (&images)[2]) {
        return shown_in(images, [&](es_client_state* state, es_error* error) {
            return es_client_render(client_, &request, images, state, error);
        });
    }
    /// A picture that was made has a width.
    template <typename Picture, typename Call>
    static Shown shown_in(Picture (&eyes)[2], Call call) {
        for (Picture& eye : eyes) {
            eye.struct_size = sizeof eye;
            eye.width = eye.height = 0;
        }
        Shown shown;
        shown.status = call(&shown.state, &shown.error);
        shown.is_there = eyes[0].width > 0;
        return shown;
    }
    /// 0 of a size that the library refuses.
    static std::size_t pixels_of(const es_client_request& request) {
        constexpr int max_side = 16384;
        const auto is_side = [](int side) { return side >= 1 && side <= max_side; };
        if (!is_side(request.width) || !is_side(request.height))
            return 0;
        return std::size_t(request.width) * std::size_t(request.height);
    }
    template <typename Call>
    static void check(Call call) {
        es_error error;
        error.text[0] = '\0';
        if (const es_status status = call(&error); status != ES_OK)
            throw ClientError(status, error);
    }
    template <typename Struct>
    static Struct empty() {
        Struct of_size{};
        of_size.struct_size = sizeof of_size;
        return of_size;
    }
    template <typename Struct, typename Get>
    Struct filled(Get get) const {
        Struct answer = empty<Struct>();
        check([&](es_error* error) { return get(client_, &answer, error); });
        return answer;
    }
    /// Rows follow each other at the picture's own width, which is the smaller one.
    template <typename Sample>
    static void pack(std::vector<Sample>& samples, int of_row, int to_row, int rows) {
        for (int y = 1; y < rows && to_row < of_row; ++y)
            for (int x = 0; x < to_row; ++x)
                samples[std::size_t(y) * std::size_t(to_row) + std::size_t(x)] =
                    samples[std::size_t(y) * std::size_t(of_row) + std::size_t(x)];
        samples.resize(std::size_t(to_row) * std::size_t(rows));
    }
    static void keep(const es_eye_image& image, int columns, ClientPicture& eye) {
        eye.width = image.width;
        eye.height = image.height;
        eye.fov = image.fov;
        pack(eye.rgba, 4 * columns, 4 * image.width, image.height);
        pack(eye.origin, columns, image.width, image.height);
        pack(eye.depth_m, columns, image.width, image.height);
        pack(eye.confidence, columns, image.width, image.height);
    }

    es_client* client_ = nullptr;
};

}  // namespace equistream
#endif
