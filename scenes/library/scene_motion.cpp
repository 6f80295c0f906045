#include "file_bytes.h"
#include "scene.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace equistream {

namespace {

/// Scale of a transform along its own axes, a mirror image counted on the first; shear is lost.
glm::dvec3 scale_of(const glm::dmat4& m) {
    glm::dvec3 scale(glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])), glm::length(glm::dvec3(m[2])));
    if (glm::determinant(glm::dmat3(m)) < 0)
        scale.x = -scale.x;
    return scale;
}

/// For each moving entry the object it names.
std::unordered_map<std::uint32_t, std::size_t> moving_objects(const SceneModel& model, const SceneDescription& scene) {
    std::unordered_map<std::string_view, std::vector<std::uint32_t>> named;
    for (const MovingObject& moving : scene.moving)
        named[moving.object];
    for (std::uint32_t object = 0; object < model.objects.size(); ++object)
        if (const auto entry = named.find(model.objects[object].name); entry != named.end())
            entry->second.push_back(object);
    std::unordered_map<std::uint32_t, std::size_t> entry_of_object;
    for (std::size_t entry = 0; entry < scene.moving.size(); ++entry) {
        const std::string& name = scene.moving[entry].object;
        const std::vector<std::uint32_t>& found = named[name];
        if (found.size() != 1)
            throw InputError(expected_found(scene.file.string(), "one node named \"" + name + "\" in the model",
                                            found.empty() ? "none" : "several"));
        if (!std::isnormal(glm::determinant(glm::mat3(model.objects[found.front()].world_from_object))))
            throw InputError(expected_found(scene.file.string(), "a node of some volume to move", "\"" + name + "\""));
        entry_of_object[found.front()] = entry;
    }
    return entry_of_object;
}

/// Flat parts of what moves are refused: renderers invert the transforms of all that does.
void require_volume(const SceneModel& model, const SceneDescription& scene,
                    const std::vector<std::uint32_t>& mover_of_object) {
    for (const Instance& instance : model.instances) {
        const std::uint32_t mover = mover_of_object[instance.object];
        if (mover != no_index && !std::isnormal(glm::determinant(glm::mat3(instance.world_from_object))))
            throw InputError(expected_found(
                scene.file.string(), "nodes of some volume below \"" + model.objects[mover].name + "\", which moves",
                "\"" + model.objects[instance.object].name + "\""));
    }
}

/// For each object the nearest of it and its parents that moves by itself; no_index where none does.
std::vector<std::uint32_t> movers(const SceneModel& model,
                                  const std::unordered_map<std::uint32_t, std::size_t>& moving) {
    constexpr std::uint32_t unknown = no_index - 1;
    std::vector<std::uint32_t> mover_of_object(model.objects.size(), unknown);
    std::vector<std::uint32_t> chain;  // up to an object whose mover is known
    for (std::uint32_t object = 0; object < model.objects.size(); ++object) {
        std::uint32_t mover = no_index;
        for (int o = static_cast<int>(object); o >= 0; o = model.objects[static_cast<std::size_t>(o)].parent) {
            const auto index = static_cast<std::uint32_t>(o);
            if (mover_of_object[index] != unknown) {
                mover = mover_of_object[index];
                break;
            }
            chain.push_back(index);
            if (moving.contains(index)) {
                mover = index;
                break;
            }
        }
        for (const std::uint32_t one : chain)
            mover_of_object[one] = mover;
        chain.clear();
    }
    return mover_of_object;
}

}  // namespace

std::vector<std::uint32_t> find_moving_instances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::vector<std::uint32_t> instances;
    if (moving.empty())
        return instances;
    const std::vector<std::uint32_t> mover_of_object = movers(model, moving);
    require_volume(model, scene, mover_of_object);
    for (std::uint32_t i = 0; i < model.instances.size(); ++i)
        if (mover_of_object[model.instances[i].object] != no_index)
            instances.push_back(i);
    return instances;
}

MovedInstances::MovedInstances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::unordered_map<std::uint32_t, std::size_t> place_of_mover;
    for (const auto& [object, entry] : moving) {
        const glm::dmat4 rest(model.objects[object].world_from_object);
        place_of_mover[object] = movers_.size();
        movers_.push_back({scene.moving[entry].path, scale_of(rest), glm::inverse(rest)});
    }
    const std::vector<std::uint32_t> mover_of_object = movers(model, moving);
    require_volume(model, scene, mover_of_object);
    for (const Instance& instance : model.instances) {
        const std::uint32_t mover = mover_of_object[instance.object];
        if (mover != no_index)
            moving_.push_back(
                {world_from_object_.size(), place_of_mover[mover], glm::dmat4(instance.world_from_object)});
        world_from_object_.push_back(instance.world_from_object);
    }
}

const std::vector<glm::mat4>& MovedInstances::at(double time_s) {
    for (Mover& mover : movers_) {
        const Pose pose = mover.path.at(time_s);
        mover.moved_from_rest = glm::translate(glm::dmat4(1), pose.position_m) * glm::mat4_cast(pose.orientation) *
                                glm::scale(glm::dmat4(1), mover.scale) * mover.object_from_rest;
    }
    for (const Moving& one : moving_)
        world_from_object_[one.instance] = glm::mat4(movers_[one.mover].moved_from_rest * one.rest);
    return world_from_object_;
}

std::vector<glm::mat4> instance_transforms(const SceneModel& model, const SceneDescription& scene, double time_s) {
    return MovedInstances(model, scene).at(time_s);
}

namespace {

constexpr std::uint64_t csv_size_limit = 64 << 20;
/// Epoch seconds beyond this (the year 2286) are milliseconds or finer.
constexpr double max_epoch_s = 1e10;
constexpr std::array<const char*, 8> columns{"time_s", "x", "y", "z", "qw", "qx", "qy", "qz"};

bool finite(const PosePath::Key& key) {
    const glm::dvec3& p = key.pose.position_m;
    const glm::dquat& q = key.pose.orientation;
    return std::isfinite(key.time_s) && std::isfinite(p.x + p.y + p.z) && std::isfinite(q.w + q.x + q.y + q.z);
}

/// The whole text as a number; "nan" and "inf" are numbers here, and refused where they are used.
std::optional<double> parse_number(std::string_view text) {
    if (!text.empty() && text.front() == '+')
        text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || text.empty())
        return std::nullopt;
    return value;
}

/// A header has no number in it: a key with a slip of the pen is an error, not a header.
bool names_columns(std::string_view line) {
    const auto fields = split_at_commas(line);
    return std::none_of(fields.begin(), fields.end(),
                        [](const auto& field) { return parse_number(field).has_value(); });
}

PosePath::Key parse_key(std::string_view line, const std::string& where) {
    const std::vector<std::string_view> fields = split_at_commas(line);
    if (fields.size() != columns.size())
        throw InputError(expected_found(where,
                                        "8 columns separated by commas, with decimal points (time_s, x, y, z, qw, qx, "
                                        "qy, qz)",
                                        std::to_string(fields.size())));
    std::array<double, 8> n{};
    for (std::size_t i = 0; i < n.size(); ++i) {
        const std::optional<double> value = parse_number(fields[i]);
        if (!value || !std::isfinite(*value))
            throw InputError(expected_found(where, std::string("a finite number as ") + columns[i],
                                            "\"" + std::string(fields[i].substr(0, 40)) + "\""));
        if (i >= 1 && i <= 3 && !is_coordinate(*value))
            throw InputError(expected_found(where, std::string("metres from -1e9 to 1e9 as ") + columns[i],
                                            "\"" + std::string(fields[i].substr(0, 40)) + "\""));
        n[i] = *value;
    }
    return {n[0], {{n[1], n[2], n[3]}, glm::dquat(n[4], n[5], n[6], n[7])}};
}

/// As in a line of CSV.
std::array<double, 8> numbers_of(const PosePath::Key& key) {
    const glm::dvec3& p = key.pose.position_m;
    const glm::dquat& q = key.pose.orientation;
    return {key.time_s, p.x, p.y, p.z, q.w, q.x, q.y, q.z};
}

void append_number(std::string& text, double value) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text.append(digits.data(), end);
}

}  // namespace

PosePath::PosePath(std::vector<Key> keys, const std::string& where) : keys_(std::move(keys)) {
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        Key& key = keys_[i];
        const std::string which = where + ", key " + std::to_string(i + 1);
        if (!finite(key))
            throw InputError(expected_found(which, "finite numbers", "NaN or infinity"));
        if (!is_position(key.pose.position_m))
            throw InputError(expected_found(which, "coordinates from -1e9 to 1e9 metres", "one outside"));
        if (i > 0 && !(key.time_s > keys_[i - 1].time_s))
            throw InputError(expected_found(which, "a time after " + std::to_string(keys_[i - 1].time_s) + " s",
                                            std::to_string(key.time_s) + " s"));
        const double length = glm::length(key.pose.orientation);
        if (!(std::abs(length - 1) < 0.01))
            throw InputError(expected_found(which, "a unit quaternion", "one of length " + std::to_string(length)));
        key.pose.orientation /= length;
    }
}

PosePath PosePath::on_frame_clock(std::vector<Key> keys, const std::string& where, double clock_start_s) {
    PosePath path(std::move(keys), where);
    if (path.empty())
        return path;
    const double first_s = path.keys_.front().time_s, last_s = path.keys_.back().time_s;
    const std::string expected = "times in seconds that span a day (86400 s) at most";
    if (!(std::abs(first_s) <= max_epoch_s && std::abs(last_s) <= max_epoch_s))
        throw InputError(expected_found(
            where, expected,
            formatted("%.17g: milliseconds or nanoseconds?", std::abs(last_s) > max_epoch_s ? last_s : first_s)));
    if (last_s < 0 || first_s > max_path_s || (clock_start_s < 0 && first_s < 0)) {
        path.clock_start_s_ = clock_start_s != 0 ? clock_start_s : first_s;
        // Doubles of epoch seconds are 0.24 us apart: a last key must not miss its frame for that.
        for (Key& key : path.keys_)
            key.time_s = std::round((key.time_s - path.clock_start_s_) * 1e6) / 1e6;
    }
    if (path.duration_s() > max_path_s)
        throw InputError(expected_found(where, expected, formatted("times from %.17g to %.17g", first_s, last_s)));
    return path;
}

std::string clock_note(const PosePath& path, const std::string& name) {
    if (path.clock_start_s() == 0)
        return "";
    return formatted("%s begins at %.17g s; its times count from its first sample", name.c_str(), path.clock_start_s());
}

Pose PosePath::at(double time_s) const {
    assert(!keys_.empty());
    if (!(time_s > keys_.front().time_s))
        return keys_.front().pose;
    const auto after =
        std::upper_bound(keys_.begin(), keys_.end(), time_s, [](double t, const Key& key) { return t < key.time_s; });
    if (after == keys_.end())
        return keys_.back().pose;
    const Key& from = *(after - 1);
    const double share = (time_s - from.time_s) / (after->time_s - from.time_s);
    return {glm::mix(from.pose.position_m, after->pose.position_m, share),
            glm::normalize(glm::slerp(from.pose.orientation, after->pose.orientation, share))};
}

PosePath read_path_csv(const std::filesystem::path& file, double clock_start_s) {
    const std::vector<std::uint8_t> bytes = read_file_bytes(file, "camera path (CSV)", csv_size_limit);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    if (text.starts_with(byte_order_mark))
        text.remove_prefix(byte_order_mark.size());
    std::vector<PosePath::Key> keys;
    int number = 0;
    bool first = true;
    for (std::size_t start = 0; start < text.size();) {
        const std::size_t end = std::min(text.find('\n', start), text.size());
        const std::string_view line = trimmed(text.substr(start, end - start));
        start = end + 1;
        ++number;
        if (line.empty() || line.front() == '#')
            continue;
        const bool header = first && names_columns(line);
        first = false;
        if (header)
            continue;
        const std::string where = file.string() + ":" + std::to_string(number);
        const PosePath::Key key = parse_key(line, where);
        PosePath({key}, where);  // the checks on one key, with its line
        if (!keys.empty() && !(key.time_s > keys.back().time_s))
            throw InputError(expected_found(where, "a time after " + std::to_string(keys.back().time_s) + " s",
                                            std::to_string(key.time_s) + " s"));
        keys.push_back(key);
    }
    if (keys.empty())
        throw InputError(expected_found(file.string(), "at least one key", "none"));
    return PosePath::on_frame_clock(std::move(keys), file.string(), clock_start_s);
}

void write_path_csv(const std::filesystem::path& file, const PosePath& path) {
    std::string text = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n";
    for (const PosePath::Key& key : path.keys()) {
        const char* separator = "";
        for (const double value : numbers_of(key)) {
            text += separator;
            append_number(text, value);
            separator = ",";
        }
        text += '\n';
    }
    write_file_atomically(file, text);
}

std::string path_fingerprint(const PosePath& path) {
    ContentHash hash;
    for (const PosePath::Key& key : path.keys()) {
        const std::array<double, 8> numbers = numbers_of(key);
        hash.add({reinterpret_cast<const std::uint8_t*>(numbers.data()), sizeof numbers});
    }
    return hash.hex();
}

}  // namespace equistream
