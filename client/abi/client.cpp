#include "caller_data.h"
#include "module_loading.h"

#include <equistream/camera_limits.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

using namespace equistream;

struct es_client {
    es_client(const SessionSettings& settings, const RayModule& ray, const GlModule& gl) : session(settings, ray, gl) {}

    Session session;
    bool has_pictures = false;  ///< the last render or draw made both pictures
};

namespace {

constexpr double max_seek_s = 1e12;

template <typename Pointer>
void require_pointer(const Pointer* pointer, const char* name) {
    if (pointer == nullptr)
        throw InputError(expected_found(name, "a pointer", "NULL"));
}

/// Of a target's corner. No framebuffer is so large.
void require_place(const std::string& field, int pixels) {
    constexpr int farthest = 65536;
    if (const auto mismatch = range_mismatch(pixels, -farthest, farthest))
        throw InputError(expected_found(field, mismatch->expected, mismatch->found));
}

void require_state(const es_client_state* state) {
    if (state != nullptr)
        require_struct(state, "es_client_state");
}

/// Why the frame before is shown is said once it is shown.
void tell(const SessionState& shown, es_client_state* state) {
    if (state != nullptr)
        fill_struct(state, "es_client_state", static_cast<const es_client_state&>(shown));
    if (!shown.problem.empty())
        throw WorkError(shown.problem);
}

GlEyes& gl_eyes_of(es_client& client) {
    GlEyes* const eyes = client.session.gl_eyes();
    if (eyes == nullptr)
        throw InputError(expected_found("client", "a client opened with ES_BACKEND_OPENGL", "one with ES_BACKEND_CPU"));
    return *eyes;
}

}  // namespace

extern "C" {

uint32_t es_client_abi_version(void) {
    return ES_CLIENT_ABI_VERSION;
}

const char* es_client_version(void) {
    return EQUISTREAM_VERSION;
}

es_status es_client_open(const es_client_settings* settings, es_client** client, es_error* error) {
    if (client != nullptr)
        *client = nullptr;
    return guarded(error, [&] {
        require_pointer(client, "es_client_open: client");
        const SessionSettings checked = checked_settings(settings);
        const bool casts_rays = !checked.by_gl && !checked.scene.empty();
        *client = new es_client(checked, casts_rays ? load_ray_module() : RayModule{},
                                checked.by_gl ? load_gl_module() : GlModule{});
    });
}

void es_client_close(es_client* client) {
    delete client;
}

es_status es_client_get_source(const es_client* client, es_client_source* source, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        const Session& session = client->session;
        const FrameInfo& first = session.first();
        es_client_source filled{.struct_size = 0,
                                .is_live = session.is_live(),
                                .has_poses = session.frame().posed,
                                .has_depth = session.has_depth(),
                                .width = width_of(first.camera),
                                .height = height_of(first.camera),
                                .frames_per_second = first.frames_per_second,
                                .ipd_m = first.ipd_m,
                                .head_box_radius_m = head_box_radius(first),
                                .first_time_s = first.time_s,
                                .first_head = pose_of(first.head),
                                .engine = {}};
        std::snprintf(filled.engine, sizeof filled.engine, "%s", session.engine().c_str());
        fill_struct(source, "es_client_source", filled);
    });
}

double es_client_now_s(const es_client* client) {
    return client == nullptr ? 0 : client->session.now_s();
}

es_status es_client_render(es_client* client, const es_client_request* request, es_eye_image images[2],
                           es_client_state* state, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        require_pointer(images, "images");
        const SessionRequest checked = checked_request(request);
        require_images(std::span<const es_eye_image, 2>(images, 2), checked);
        require_state(state);
        client->has_pictures = false;
        const SessionState shown = client->session.render(checked);
        client->has_pictures = true;
        const SessionPictures& pictures = client->session.pictures();
        for (std::size_t i = 0; i < 2; ++i)
            write_image(pictures.eyes[i], pictures.view.parts[i], checked, images[i]);
        tell(shown, state);
    });
}

es_status es_client_draw(es_client* client, const es_client_request* request, es_gl_target targets[2],
                         es_client_state* state, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        require_pointer(targets, "targets");
        GlEyes& eyes = gl_eyes_of(*client);
        const SessionRequest checked = checked_request(request);
        std::array<GlHostTarget, 2> to;
        for (std::size_t i = 0; i < 2; ++i) {
            const std::string name = "targets[" + std::to_string(i) + "]";
            const es_gl_target& given = targets[i];
            require_exact_size(name, sizeof given, given.struct_size);
            require_place(name + ".x", given.x);
            require_place(name + ".y", given.y);
            to[i] = {given.framebuffer, given.x, given.y, given.origin, given.depth_m, given.confidence};
            eyes.require_target(to[i], checked.width, checked.height, name);
        }
        require_state(state);
        client->has_pictures = false;
        const SessionState shown = client->session.draw(checked);
        client->has_pictures = true;
        for (int i = 0; i < 2; ++i) {
            const ViewPart& part = client->session.view().parts[std::size_t(i)];
            eyes.write(i, part, to[std::size_t(i)]);
            es_gl_target& target = targets[i];
            target.width = part.width;
            target.height = part.height;
            target.fov = fov_of(part.fov);
        }
        tell(shown, state);
    });
}

es_status es_client_get_textures(es_client* client, es_gl_textures* textures, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        require_struct(textures, "es_gl_textures");
        const GlEyesTextures names = gl_eyes_of(*client).textures();
        if (!client->has_pictures)
            throw InputError(expected_found("client", "one that has drawn", "one that has not"));
        es_gl_textures filled{.struct_size = 0,
                              .colour = names.colour,
                              .origin = names.origin,
                              .inverse_depth = names.inverse_depth,
                              .confidence = names.confidence,
                              .inverse_depth_scale = names.inverse_depth_scale,
                              .x = {},
                              .y = {},
                              .width = {},
                              .height = {}};
        for (int i = 0; i < 2; ++i) {
            const ViewPart& part = client->session.view().parts[std::size_t(i)];
            filled.x[i] = part.left;
            filled.y[i] = part.top;
            filled.width[i] = part.width;
            filled.height[i] = part.height;
        }
        fill_struct(textures, "es_gl_textures", filled);
    });
}

es_status es_client_send_head(es_client* client, const es_pose* head, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        require_pointer(head, "head");
        client->session.send_head(checked_pose("head", *head));
    });
}

void es_client_pause(es_client* client) {
    if (client != nullptr)
        client->session.pause();
}

void es_client_play(es_client* client) {
    if (client != nullptr)
        guarded(nullptr, [&] { client->session.play(); });
}

es_status es_client_seek(es_client* client, double time_s, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        if (const auto mismatch = range_mismatch(time_s, -max_seek_s, max_seek_s))
            throw InputError(expected_found("time_s", mismatch->expected, mismatch->found));
        client->session.seek(time_s);
    });
}

es_status es_client_get_statistics(const es_client* client, es_client_statistics* statistics, es_error* error) {
    return guarded(error, [&] {
        require_pointer(client, "client");
        fill_struct(statistics, "es_client_statistics", client->session.statistics());
    });
}

es_status es_client_set_eyes(es_client_request* request, double fov_x_rad, double ipd_m, es_error* error) {
    return guarded(error, [&] {
        const std::size_t sizes[] = {sizeof(es_client_request)};
        const es_client_request given = whole_struct(request, "es_client_request", sizes);
        if (const auto mismatch = range_mismatch(fov_x_rad, 1e-3, 2 * 85 * pi / 180))
            throw InputError(expected_found("fov_x_rad", mismatch->expected, mismatch->found));
        if (const auto mismatch = range_mismatch(ipd_m, 0, max_ipd_m))
            throw InputError(expected_found("ipd_m", mismatch->expected, mismatch->found));
        if (given.width < 1 || given.height < 1)
            throw InputError(expected_found("width, height", "at least 1",
                                            std::to_string(given.width) + ", " + std::to_string(given.height)));
        const double up = std::atan(std::tan(fov_x_rad / 2) * given.height / given.width);
        for (int i = 0; i < 2; ++i) {
            request->eyes[i].in_head = {{(i == 0 ? -0.5 : 0.5) * ipd_m, 0, 0}, {1, 0, 0, 0}};
            request->eyes[i].fov = {-fov_x_rad / 2, fov_x_rad / 2, up, -up};
        }
    });
}

}  // extern "C"
