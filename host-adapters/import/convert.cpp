#include "convert.h"

#include <equistream/aov.h>
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <Imath/half.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream::files {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

template <typename Sample>
void mirror(Image<Sample>& image) {
    for (int y = 0; y < image.height(); ++y)
        std::reverse(image.pixel(0, y), image.pixel(0, y) + image.width());
}

class Converter {
public:
    Converter(const std::vector<const ForeignExr*>& files, const Conversion& conversion,
              std::vector<std::string>& notes)
        : files_(files), conversion_(conversion), conventions_(conversion.conventions), notes_(notes),
          pose_(sphere_pose(conversion, conversion.camera_pose)) {}

    void convert(const MappedPlane& mapped, Frame& frame) {
        mapped_ = &mapped;
        const AovInfo aov = *find_aov(mapped.plane);
        if (aov.type == SampleType::id) {
            frame.ids[mapped.plane] = ids();
            return;
        }
        FloatImage plane;
        if (mapped.plane == "depth" || mapped.plane == "virtual_depth")
            plane = depth();
        else if (is_backward() || mapped.plane == "forward" || mapped.plane == "virtual_forward")
            plane = motion(is_backward() ? *conventions_.backward : *conventions_.forward, frame);
        else if (mapped.plane == "normal")
            plane = normals();
        else
            plane = light(int(aov.channels.size()), aov.name != "guide_normal");
        try {
            require_plane_values(aov, plane.view());
        } catch (const InputError& problem) {
            throw InputError(file().file().string() + ": " + problem.what());
        }
        frame.planes[mapped.plane] = std::move(plane);
    }

    const Pose& pose() const { return pose_; }

private:
    bool is_backward() const { return mapped_->plane == "backward" || mapped_->plane == "virtual_backward"; }
    const ForeignExr& file() const { return *files_[std::size_t(mapped_->set)]; }
    int width() const { return width_of(conversion_.camera); }
    int height() const { return height_of(conversion_.camera); }
    bool is_sphere() const { return std::holds_alternative<EquirectCamera>(conversion_.camera); }

    FloatImage channel(std::size_t index, float outside = 0) const {
        return in_our_layout(file().read(mapped_->channels[index], outside));
    }

    /// As our spheres lie.
    template <typename Image>
    Image in_our_layout(Image image) const {
        if (is_sphere() && conventions_.mirrored)
            mirror(image);
        if (is_sphere() && conventions_.one_row_low)
            for (int y = 0; y + 1 < image.height(); ++y)
                std::copy_n(image.pixel(0, y + 1), image.width() * image.channels(), image.pixel(0, y));
        return image;
    }

    template <typename Compute>
    FloatImage filled(int channels, const Compute& compute) const {
        FloatImage image(width(), height(), channels);
        for (int y = 0; y < height(); ++y)
            for (int x = 0; x < width(); ++x)
                compute(x, y, image.pixel(x, y));
        return image;
    }

    /// A file holds floats or halves, and 0.1 is neither.
    double as_stored(double value) const {
        const auto number = float(value);
        return double(mapped_->channels.front().is_half ? float(Imath::half(number)) : number);
    }

    bool is_miss(double value) const {
        return value >= conventions_.miss_above ||
               (conventions_.miss_value && value == as_stored(*conventions_.miss_value));
    }

    FloatImage depth() const {
        if (conventions_.depth == DepthKind::position)
            return depth_of_positions();
        const FloatImage raw = channel(0, infinity);
        const bool planar = conventions_.depth == DepthKind::planar;
        return filled(1, [&](int x, int y, float* out) {
            const double value = double(*raw.pixel(x, y));
            if (is_miss(value)) {
                *out = infinity;
                return;
            }
            const double cosine = is_sphere() ? 1 : -direction_of(conversion_.camera, x + 0.5, y + 0.5).z;
            const double scaled = value * conventions_.depth_scale_m;
            *out = float(planar ? (scaled + conventions_.near_plane_m) / cosine
                                : scaled + conventions_.near_plane_m / cosine);
        });
    }

    FloatImage depth_of_positions() const {
        const FloatImage p[] = {channel(0, infinity), channel(1, infinity), channel(2, infinity)};
        return filled(1, [&](int x, int y, float* out) {
            const glm::dvec3 point(*p[0].pixel(x, y), *p[1].pixel(x, y), *p[2].pixel(x, y));
            const double distance = glm::length(point);
            *out = is_miss(distance) ? infinity : float(distance * conventions_.depth_scale_m);
        });
    }

    FloatImage motion(const MotionConvention& m, const Frame& frame) const {
        const FloatImage u = channel(0), v = channel(1);
        const double scale = m.unit == MotionUnit::ndc ? 0.5 : 1;
        const double sign = m.ends == MotionEnds::from_previous || m.ends == MotionEnds::from_next ? -1 : 1;
        const int columns = conversion_.sphere_columns.value_or(width());
        const int rows = conversion_.sphere_columns ? columns / 2 : height();
        const double u_scale = sign * (m.unit == MotionUnit::pixels ? 1 : scale * columns) *
                               (conventions_.mirrored && is_sphere() ? -1 : 1);
        const double v_scale = sign * (m.unit == MotionUnit::pixels ? 1 : scale * rows) * (m.y_up ? -1 : 1);
        const auto& neighbour = is_backward() ? conversion_.previous : conversion_.next;
        const auto depth = frame.planes.find("depth");
        return filled(2, [&](int x, int y, float* out) {
            double du = u_scale * double(*u.pixel(x, y));
            const double dv = v_scale * double(*v.pixel(x, y));
            du = shortest(du);
            out[0] = float(du), out[1] = float(dv);
            if (neighbour && depth != frame.planes.end() && std::isinf(*depth->second.pixel(x, y)))
                move_by_rotation(x, y, *neighbour, out);
        });
    }

    /// The way round the sphere.
    double shortest(double columns) const {
        if (conversion_.sphere_columns)
            return shortest_column_difference(columns, *conversion_.sphere_columns, {});
        const auto* sphere = std::get_if<EquirectCamera>(&conversion_.camera);
        return sphere != nullptr ? shortest_column_difference(columns, sphere->width, sphere->range) : columns;
    }

    /// A miss is infinitely far away; what a renderer writes there differs.
    void move_by_rotation(int x, int y, const Pose& neighbour, float* out) const {
        const Pose there = sphere_pose(conversion_, neighbour);
        const glm::dvec3 d = direction_of(conversion_.camera, x + 0.5, y + 0.5);
        const glm::dvec2 p = pixel_of(conversion_.camera, glm::inverse(there.orientation) * (pose_.orientation * d));
        const glm::dvec2 difference = p - glm::dvec2(x + 0.5, y + 0.5);
        if (!std::isfinite(difference.x))
            return;  // behind a perspective camera: what was written stays
        out[0] = float(shortest(difference.x)), out[1] = float(difference.y);
    }

    FloatImage normals() const {
        const FloatImage n[] = {channel(0), channel(1), channel(2)};
        const bool turn = conversion_.pose_is_known || conventions_.normals != NormalSpace::world;
        const glm::dquat up = glm::angleAxis(conventions_.z_up ? -pi / 2 : 0.0, glm::dvec3(1, 0, 0));
        return filled(3, [&](int x, int y, float* out) {
            glm::dvec3 normal(*n[0].pixel(x, y), *n[1].pixel(x, y), *n[2].pixel(x, y));
            if (conventions_.normals_encoded && normal != glm::dvec3(0))
                normal = 2.0 * normal - 1.0;
            const double length = glm::length(normal);
            out[0] = out[1] = out[2] = 0;
            if (!(length > 1e-6))
                return;
            normal /= length;
            if (conventions_.normals == NormalSpace::camera_z_forward)
                normal.z = -normal.z;
            normal =
                conventions_.normals == NormalSpace::world ? up * normal : conversion_.camera_pose.orientation * normal;
            const glm::dvec3 ray = pose_.orientation * direction_of(conversion_.camera, x + 0.5, y + 0.5);
            if (turn && glm::dot(normal, ray) > 0)
                normal = -normal;
            out[0] = float(normal.x), out[1] = float(normal.y), out[2] = float(normal.z);
        });
    }

    FloatImage light(int channels, bool has_colours) const {
        std::vector<FloatImage> source;
        for (std::size_t i = 0; i < mapped_->channels.size(); ++i)
            source.push_back(channel(i));
        const bool is_colour = source.size() >= 3 && has_colours;
        // Alpha that a file does not have: 1 within its data window, where two readings do not differ.
        const FloatImage ones = channels == 4 && source.size() == 3 ? channel(0, 1) : FloatImage();
        return filled(channels, [&](int x, int y, float* out) {
            for (std::size_t i = 0; i < source.size(); ++i)
                out[i] = *source[i].pixel(x, y);
            if (is_colour && conversion_.colour_to_rec709 != glm::dmat3(1)) {
                const glm::dvec3 rgb = conversion_.colour_to_rec709 * glm::dvec3(out[0], out[1], out[2]);
                out[0] = float(rgb.x), out[1] = float(rgb.y), out[2] = float(rgb.z);
            }
            if (channels == 4 && source.size() == 3)
                out[3] = *source[0].pixel(x, y) == 0 && *ones.pixel(x, y) == 1 ? 0 : 1;
        });
    }

    IdImage ids() {
        if (mapped_->channels[0].is_id)
            return in_our_layout(file().read_ids(mapped_->channels[0]));
        IdImage image(width(), height(), 1);
        const FloatImage raw = channel(0);
        std::int64_t rounded = 0;
        for (int y = 0; y < height(); ++y)
            for (int x = 0; x < width(); ++x) {
                const double value = double(*raw.pixel(x, y));
                if (!(value > -0.5 && value < 4294967295.0))
                    throw InputError(expected_found(file().file().string() + ": plane " + mapped_->plane +
                                                        " at pixel " + std::to_string(x) + "," + std::to_string(y),
                                                    "a whole number from 0", std::to_string(value)));
                rounded += value != std::round(value) ? 1 : 0;
                *image.pixel(x, y) = std::uint32_t(std::lround(value));
            }
        if (rounded > 0)
            notes_.push_back(file().file().string() + ": " + mapped_->plane + ": " + std::to_string(rounded) +
                             " pixels were not whole numbers and are rounded (was the plane filtered?)");
        return image;
    }

    const std::vector<const ForeignExr*>& files_;
    const Conversion& conversion_;
    const SourceConventions& conventions_;
    std::vector<std::string>& notes_;
    Pose pose_;
    const MappedPlane* mapped_ = nullptr;
};

}  // namespace

Frame convert_frame(const std::vector<const ForeignExr*>& files, const ChannelMap& map, const Conversion& conversion,
                    const FrameInfo& info, std::vector<std::string>& notes) {
    for (const ForeignExr* file : files)
        if (file->width() != width_of(conversion.camera) || file->height() != height_of(conversion.camera))
            throw InputError(expected_found(file->file().string(),
                                            std::to_string(width_of(conversion.camera)) + "x" +
                                                std::to_string(height_of(conversion.camera)) + " as in the first file",
                                            std::to_string(file->width()) + "x" + std::to_string(file->height())));
    Converter converter(files, conversion, notes);
    Frame frame;
    frame.info = info;
    frame.info.camera = conversion.camera;
    frame.info.camera_pose = converter.pose();
    for (const MappedPlane& mapped : map.planes)  // the catalogue's order: depth comes before motion
        converter.convert(mapped, frame);
    return frame;
}

std::optional<std::pair<WindowGrid, WindowPlace>> window_of(const std::vector<const ForeignExr*>& files,
                                                            bool mirrored) {
    int left = 0, top = 0, right = files.front()->width(), bottom = files.front()->height();
    for (const ForeignExr* file : files) {
        const ForeignExr::Rectangle pixels = file->pixels();
        const int x = mirrored ? file->width() - pixels.x - pixels.width : pixels.x;
        left = std::max(left, x), right = std::min(right, x + pixels.width);
        top = std::max(top, pixels.y), bottom = std::min(bottom, pixels.y + pixels.height);
    }
    const auto up = [](int pixel) { return (pixel + window_block_px - 1) / window_block_px * window_block_px; };
    const auto down = [](int pixel) { return pixel / window_block_px * window_block_px; };
    const WindowPlace place{up(left), up(top)};
    const WindowGrid grid{files.front()->width(), files.front()->height(), down(right) - place.x,
                          down(bottom) - place.y};
    if (grid.width <= 0 || grid.height <= 0)
        return std::nullopt;
    return std::pair(grid, place);
}

void cut_out(const WindowGrid& grid, WindowPlace place, Frame& frame) {
    for (auto& [name, plane] : frame.planes)
        plane = window_pixels(plane, grid, place);
    for (auto& [name, plane] : frame.ids)
        plane = window_pixels(plane, grid, place);
    frame.info.camera = window_camera(grid, place);
}

Chromaticities named_chromaticities(const std::string& name) {
    constexpr glm::dvec2 aces_white{0.32168, 0.33767};
    if (name == "rec709")
        return rec709_chromaticities;
    if (name == "rec2020")
        return {glm::dvec2{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
    if (name == "acescg")
        return {glm::dvec2{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, aces_white};
    if (name == "aces2065-1")
        return {glm::dvec2{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, aces_white};
    throw InputError(expected_found("--colour-space", "auto, rec709, rec2020, acescg or aces2065-1", "'" + name + "'"));
}

namespace {

/// Both ways of writing a matrix are about; a translation tells which, and without one the preset does.
bool has_column_vectors(const glm::dmat4& m, const SourceConventions& conventions) {
    const double row = std::abs(m[3][0]) + std::abs(m[3][1]) + std::abs(m[3][2]);
    const double column = std::abs(m[0][3]) + std::abs(m[1][3]) + std::abs(m[2][3]);
    if ((row > 1e-9) == (column > 1e-9))
        return conventions.column_vectors;
    return column > 1e-9;
}

}  // namespace

Pose pose_of_attribute(const ForeignExr& file, const SourceConventions& conventions, std::string& taken_for) {
    const glm::dmat4 stored = *file.world_to_camera();  // glm's [i] is the file's row i
    const std::string where = file.file().string() + ": worldToCamera";
    const bool column_vectors = has_column_vectors(stored, conventions);
    // Of column vectors: camera = turn * world + move. glm's columns are the file's rows.
    const glm::dmat4 m = column_vectors ? glm::transpose(stored) : stored;
    glm::dmat3 turn(m);
    glm::dvec3 move(m[3]);
    const glm::dmat3 unity = turn * glm::transpose(turn);
    for (int i = 0; i < 9; ++i)
        if (!(std::abs(unity[i / 3][i % 3] - (i % 4 == 0 ? 1 : 0)) < 1e-3))
            throw InputError(expected_found(where, "a rotation and a translation (--path gives poses instead)",
                                            "a matrix that scales, shears or is 0"));
    const glm::dmat3 flip_z({1, 0, 0}, {0, 1, 0}, {0, 0, -1});
    taken_for = column_vectors ? "column vectors" : "row vectors";
    if (glm::determinant(turn) < 0) {
        taken_for += ", camera looking along +Z";
        turn = flip_z * turn;
        move = flip_z * move;
    } else if (conventions.name == "pbrt") {
        taken_for += ", left-handed world, Z reversed";
        turn = flip_z * turn * flip_z;
        move = flip_z * move;
    } else {
        taken_for += ", camera looking along -Z";
    }
    const glm::dmat3 world_from_camera = glm::transpose(turn);
    const Pose pose{-(world_from_camera * move) * conventions.depth_scale_m,
                    glm::normalize(glm::quat_cast(world_from_camera))};
    if (const auto wrong = position_mismatch(pose.position_m))
        throw InputError(expected_found(where, wrong->expected, wrong->found));
    return pose;
}

std::optional<double> fov_of_attributes(const ForeignExr& file, const SourceConventions& conventions) {
    const auto camera = file.world_to_camera(), ndc = file.world_to_ndc();
    // pbrt itself doubts what it writes there, and it is not what its field of view says unless the picture is square.
    if (!camera || !ndc || conventions.name == "pbrt")
        return std::nullopt;
    const bool column_vectors = has_column_vectors(*camera, conventions);
    const glm::dmat4 turn = column_vectors ? glm::transpose(*camera) : *camera;
    if (std::abs(glm::determinant(turn)) < 1e-9)
        return std::nullopt;
    const glm::dmat4 projection = (column_vectors ? glm::transpose(*ndc) : *ndc) * glm::inverse(turn);
    const double ahead = glm::determinant(glm::dmat3(turn)) < 0 ? 1 : -1;
    const auto across = [&](double x) {
        const glm::dvec4 p = projection * glm::dvec4(x, 0, ahead, 1);
        return p.x / p.w;
    };
    const double middle = across(0), half = std::abs(middle - 0.5) < 1e-3 ? 0.5 : 1;
    const double fov_rad = 2 * std::atan(half / std::abs(across(1) - middle));
    const bool is_centred = half == 0.5 || std::abs(middle) < 1e-3;
    return is_centred && fov_rad > 0.001 && fov_rad < pi - 0.001 ? std::optional(fov_rad) : std::nullopt;
}

Pose pose_from_z_up(const Pose& pose) {
    const glm::dquat turn = glm::angleAxis(-pi / 2, glm::dvec3(1, 0, 0));
    return {turn * pose.position_m, turn * pose.orientation};
}

Pose sphere_pose(const Conversion& conversion, const Pose& camera_pose) {
    if (!std::holds_alternative<EquirectCamera>(conversion.camera))
        return camera_pose;
    const double yaw = 2 * pi * (conversion.conventions.forward_at - 0.5);
    return {camera_pose.position_m, camera_pose.orientation * glm::angleAxis(yaw, glm::dvec3(0, 1, 0))};
}

}  // namespace equistream::files
