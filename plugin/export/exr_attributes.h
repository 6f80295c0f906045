#pragma once
/// FrameInfo as EXR attributes and back (docs/conventions.md, "EXR files").
#include "exr_session.h"
#include "unit_orientation.h"

#include <equistream/camera.h>
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/frame.h>
#include <equistream/patches.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

namespace equistream {

/// Writes every attribute of `info` to one part; the names appear in every part of a file.
void write_attributes(const ExrSession& session, int part, const FrameInfo& info);

/// Notes in one part that so many colour samples were not finite and are in no pixel's mean.
void write_left_out_samples(const ExrSession& session, int part, std::int64_t count);

/// True for a file of ours: one that carries equistream:version.
bool has_attributes(const ExrSession& session);

/// Reads and checks the first part's attributes; throws InputError naming file and attribute.
FrameInfo read_attributes(const ExrSession& session, int width, int height);

// One EXR attribute at a time, written and read; what is read is checked, and every complaint names file and
// attribute.

class AttributeWriter {
public:
    AttributeWriter(const ExrSession& session, int part) : session_(session), part_(part) {}

    void text(const char* name, const std::string& value) {
        check(exr_attr_set_string(session_.context(), part_, name, value.c_str()), name);
    }
    void number(const char* name, double value) {
        check(exr_attr_set_double(session_.context(), part_, name, value), name);
    }
    void integer(const char* name, std::int32_t value) {
        check(exr_attr_set_int(session_.context(), part_, name, value), name);
    }
    void pair(const char* name, double first, double second) {
        exr_attr_v2d_t value{};
        value.x = first;
        value.y = second;
        check(exr_attr_set_v2d(session_.context(), part_, name, &value), name);
    }
    void pose(const char* position_name, const char* orientation_name, const Pose& pose) {
        exr_attr_v3d_t position{};
        position.x = pose.position_m.x;
        position.y = pose.position_m.y;
        position.z = pose.position_m.z;
        check(exr_attr_set_v3d(session_.context(), part_, position_name, &position), position_name);
        const glm::dquat& q = pose.orientation;
        text(orientation_name, formatted("%.17g %.17g %.17g %.17g", q.w, q.x, q.y, q.z));
    }
    void check(exr_result_t result, const char* name) { session_.check(result, name); }
    exr_context_t context() const { return session_.context(); }
    int part() const { return part_; }

private:
    const ExrSession& session_;
    int part_;
};

class AttributeReader {
public:
    explicit AttributeReader(const ExrSession& session) : session_(session) {}

    bool has(const char* name) const {
        const exr_attribute_t* attribute = nullptr;
        const bool present = exr_get_attribute_by_name(session_.context(), 0, name, &attribute) == EXR_ERR_SUCCESS;
        session_.forget_errors();
        return present;
    }
    std::string text(const char* name) const {
        std::int32_t length = 0;
        const char* value = nullptr;
        require(exr_attr_get_string(session_.context(), 0, name, &length, &value), name, "a string");
        return value == nullptr ? std::string() : std::string(value, static_cast<std::size_t>(std::max(length, 0)));
    }
    std::string short_text(const char* name) const {
        std::string value = text(name);
        if (value.size() > 255)
            refuse(name, "at most 255 bytes", std::to_string(value.size()));
        return value;
    }
    double number(const char* name) const {
        double value = 0;
        require(exr_attr_get_double(session_.context(), 0, name, &value), name, "a double");
        return value;
    }
    double number(const char* name, double min, double max) const {
        const double value = number(name);
        require(range_mismatch(value, min, max), name);
        return value;
    }
    double field_of_view(const char* name) const {
        const double value = number(name);
        require(fov_mismatch(value), name);
        return value;
    }
    std::int32_t integer(const char* name) const {
        std::int32_t value = 0;
        require(exr_attr_get_int(session_.context(), 0, name, &value), name, "an int");
        return value;
    }
    template <typename T>
    T decimal(const char* name) const {
        const std::string digits = text(name);
        T value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc() || end != digits.data() + digits.size())
            refuse(name, "a whole number", "\"" + digits.substr(0, 40) + "\"");
        return value;
    }
    std::int64_t frame_index(const char* name) const {
        const auto value = decimal<std::int64_t>(name);
        if (value < 0 || value > max_frame_index)
            refuse(name, "0 to " + std::to_string(max_frame_index), std::to_string(value));
        return value;
    }
    template <std::size_t N>
    int choice(const char* name, const char* const (&names)[N]) const {
        const std::string word = text(name);
        for (std::size_t i = 0; i < N; ++i)
            if (word == names[i])
                return static_cast<int>(i);
        refuse(name, std::string("one of ") + names[0] + " ... " + names[N - 1], "\"" + word.substr(0, 40) + "\"");
    }
    /// By span_mismatch and its like (camera_limits.h).
    exr_attr_v2d_t range(const char* name, std::optional<Mismatch> (*mismatch)(double from, double to)) const {
        exr_attr_v2d_t value{};
        require(exr_attr_get_v2d(session_.context(), 0, name, &value), name, "a v2d");
        require(mismatch(value.x, value.y), name);
        return value;
    }
    Pose pose(const char* position_name, const char* orientation_name) const {
        exr_attr_v3d_t position{};
        require(exr_attr_get_v3d(session_.context(), 0, position_name, &position), position_name, "a v3d");
        const Pose pose{{position.x, position.y, position.z}, quaternion(orientation_name)};
        require(position_mismatch(pose.position_m), position_name);
        require(orientation_mismatch(pose.orientation), orientation_name);
        return {pose.position_m, unit_orientation(pose.orientation)};
    }
    std::string file() const { return session_.file().string(); }
    [[noreturn]] void refuse(const char* name, const std::string& expected, const std::string& found) const {
        throw InputError(expected_found(session_.file().string() + ": " + name, expected, found));
    }

private:
    /// Four numbers between spaces.
    glm::dquat quaternion(const char* name) const {
        const std::string words = text(name);
        std::array<double, 4> wxyz{};
        std::string_view left = words;
        for (std::size_t i = 0; i < wxyz.size(); ++i) {
            const std::size_t end = i + 1 < wxyz.size() ? left.find(' ') : left.size();
            const std::optional<double> number = parsed_number(left.substr(0, end));
            if (!number || end == std::string_view::npos)
                refuse(name, "four numbers w x y z", "\"" + words.substr(0, 80) + "\"");
            wxyz[i] = *number;
            left.remove_prefix(std::min(end + 1, left.size()));
        }
        return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
    }
    void require(const std::optional<Mismatch>& mismatch, const char* name) const {
        if (mismatch)
            refuse(name, mismatch->expected, mismatch->found);
    }
    void require(exr_result_t result, const char* name, const char* kind) const {
        if (result == EXR_ERR_SUCCESS)
            return;
        refuse(name, kind, result == EXR_ERR_NO_ATTR_BY_NAME ? "none" : exr_get_default_error_message(result));
    }

    const ExrSession& session_;
};

// A PatchAtlas as EXR attributes and back (docs/conventions.md, "EXR files").

/// Throws InputError for an atlas that is not sound.
void write_patches(AttributeWriter& out, const PatchAtlas& atlas);

bool has_patches(const AttributeReader& in);

/// All but the sphere's range, which is the camera's. `width` and `height` are the picture's; throws InputError naming
/// file and attribute.
PatchAtlas read_patches(const AttributeReader& in, int width, int height);

}  // namespace equistream
