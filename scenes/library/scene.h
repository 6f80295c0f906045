#pragma once
/// A scene description: a short JSON file that names a model and adds what it lacks - lights, camera path, head box,
/// exposure, moving objects. Keys are documented in docs/scenes.md; unknown ones are errors with file and line.
#include "model.h"

#include <equistream/camera.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// The longest path, a day: more is a slip of the unit, as of nanoseconds taken for seconds.
inline constexpr double max_path_s = 86400;

/// Poses over time: linear in position, slerp in orientation, held before the first and after the last key.
class PosePath {
public:
    struct Key {
        double time_s = 0;
        Pose pose;
    };
    PosePath() = default;
    /// Keys must ascend strictly in time and be finite; throws InputError with `where` otherwise.
    PosePath(std::vector<Key> keys, const std::string& where);
    /// Of keys on any clock in seconds. Frames begin at time 0: where every key is before it or more than max_path_s
    /// after it (epoch seconds), times count from `clock_start_s`, or, where that is 0, from the first key. Throws
    /// InputError for longer paths and other units.
    static PosePath on_frame_clock(std::vector<Key> keys, const std::string& where, double clock_start_s = 0);

    bool empty() const { return keys_.empty(); }
    double duration_s() const { return keys_.empty() ? 0 : keys_.back().time_s; }
    Pose at(double time_s) const;
    const std::vector<Key>& keys() const { return keys_; }
    /// What on_frame_clock subtracted from all times; 0 where they are as they were.
    double clock_start_s() const { return clock_start_s_; }

private:
    std::vector<Key> keys_;
    double clock_start_s_ = 0;
};

/// One sentence for the user where a path's times count from its first key; else empty.
std::string clock_note(const PosePath& path, const std::string& name);

/// CSV: time_s, position x y z in metres, orientation quaternion w x y z; a header line is allowed. Times are put on
/// the frames' clock. Errors carry file:line.
PosePath read_path_csv(const std::filesystem::path& file, double clock_start_s = 0);
void write_path_csv(const std::filesystem::path& file, const PosePath& path);

/// 16 hexadecimal digits over all its keys: another path has others.
std::string path_fingerprint(const PosePath& path);

struct Sun {
    glm::dvec3 towards{0, 1, 0};  ///< unit, from the scene to the sun
    glm::dvec3 irradiance{0};     ///< on a plane facing it
    double angular_radius_rad = 0.00465;
};

/// What rays that miss everything see: a lat-long image of linear Rec.709 radiance in the mapping of conventions.h (its
/// centre is -Z, right of it +X). The image is the host's to read; load_scene finds and fingerprints it.
struct SkyImage {
    std::filesystem::path file;  ///< resolved as the model is
    double rotation_rad = 0;     ///< direction in the world = R_y(rotation_rad) direction in the image
    glm::dvec3 scale{1};         ///< factor on the image's radiance
};

/// A node of the model that moves: its path replaces the node's own translation and rotation (world space), scale
/// stays.
struct MovingObject {
    std::string object;
    PosePath path;
};

struct SceneDescription {
    std::filesystem::path file;
    std::string name;
    std::filesystem::path model;  ///< resolved: beside the description, or under $EQUISTREAM_SCENES
    double model_unit_m = 1;      ///< metres that one unit of the model stands for; load_model(scene) applies it
    std::optional<Sun> sun;
    glm::dvec3 sky_radiance{0};  ///< constant; 0 where there is a sky_image
    std::optional<SkyImage> sky_image;
    PosePath camera_path;
    double head_radius_m = 0;
    double exposure = 1;
    double frames_per_second = 30;
    std::vector<MovingObject> moving;
    std::string fingerprint;  ///< hash of the description's, the paths', the sky image's and the model's bytes
    /// Hash of what depth comes from: the model's bytes, files it names included, its unit, and the moving objects'
    /// paths.
    std::string geometry_fingerprint;
    /// Of a client's model (`equistream model`): the geometry_fingerprint of the scene it stands for; else empty.
    std::string stands_for;

    /// The geometry that depth from here fits: the scene's that it stands for, or its own.
    const std::string& depth_of_geometry() const { return stands_for.empty() ? geometry_fingerprint : stands_for; }
};

/// What a scene is called that has no name: its file's, as a manifest holds it.
std::string scene_name_of(const std::filesystem::path& file);

/// Reads and checks a description. If the model is nowhere to be found the error lists the places looked in.
SceneDescription load_scene(const std::filesystem::path& file);

/// The scene's model in metres: scaled by model_unit_m, about the origin.
SceneModel load_model(const SceneDescription& scene, const ModelOptions& options = {});

/// Bytes of a description that load_scene reads. An hour of a head at 90 keys a second, with all digits, is half of it.
inline constexpr std::uint64_t description_size_limit = 128 << 20;
/// The JSON text of a description (docs/scenes.md). `model_from_it` is the way to the model from where it will lie.
/// Where that is empty the model lies beside it: as the file that `model` names, or as NAME.glb where it names none.
/// Throws InputError where it would be longer than `limit_bytes`.
std::string description_text(const SceneDescription& description, std::uint64_t limit_bytes = description_size_limit,
                             const std::filesystem::path& model_from_it = {});

/// 16 hexadecimal digits over the bytes of files, and over a text.
std::string content_fingerprint(const std::vector<std::filesystem::path>& files, const std::string& text);

/// Instances that scene.moving moves, by itself or with a parent, ascending: what BvhOptions::moving_instances wants.
/// Throws InputError if an entry names no node of the model, or several.
std::vector<std::uint32_t> find_moving_instances(const SceneModel& model, const SceneDescription& scene);

/// World transforms of all instances, again and again: asks for memory only when it is made. One thread at a time.
class MovedInstances {
public:
    /// Throws InputError as find_moving_instances does. Nothing is borrowed.
    MovedInstances(const SceneModel& model, const SceneDescription& scene);

    bool any_moves() const { return !moving_.empty(); }
    /// At a time; until the next call.
    const std::vector<glm::mat4>& at(double time_s);

private:
    struct Mover {
        PosePath path;
        glm::dvec3 scale;
        glm::dmat4 object_from_rest;
        glm::dmat4 moved_from_rest{1};  ///< at the time asked for last
    };
    struct Moving {
        std::size_t instance, mover;
        glm::dmat4 rest;
    };

    std::vector<Mover> movers_;
    std::vector<Moving> moving_;
    std::vector<glm::mat4> world_from_object_;
};

/// World transforms of all instances at a time (moving objects applied).
std::vector<glm::mat4> instance_transforms(const SceneModel& model, const SceneDescription& scene, double time_s);

}  // namespace equistream
