#pragma once
/// A scene in Mitsuba's hands. Plain C++17: nothing of Mitsuba in sight, so that those who use it may be compiled
/// otherwise than the wheel wants. Everything here is in Mitsuba's own world and in its units; one thread at a time.
/// Throws std::runtime_error with Mitsuba's words on one line.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream::mitsuba_host {

/// Row-major, 3 rows of 4: world from something.
using Matrix34 = std::array<double, 12>;

struct EngineOptions {
    std::string variant;                ///< empty: llvm_ad_rgb where LLVM loads, else scalar_rgb
    unsigned threads = 0;               ///< 0: one per processor
    std::filesystem::path plugin_root;  ///< its sub-folder plugins/ holds ours
};

/// Mitsuba's process-wide state. One at a time; outlives every scene.
class Engine {
public:
    explicit Engine(const EngineOptions& options);
    ~Engine();
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    const std::string& variant() const { return variant_; }
    /// Such as "3.9.1".
    static std::string release();

private:
    std::string variant_;
};

/// What of a sphere a sensor sees.
struct SphereRange {
    double longitude_min_deg = -180, longitude_max_deg = 180;
    double latitude_min_deg = -90, latitude_max_deg = 90;
};

/// A film and the sensor of ours that exposes it: one for each stream of a render.
struct SensorRequest {
    int width = 0, height = 0;
    bool perspective = false;  ///< flat view, else a sphere
    double fov_x_deg = 90;     ///< of a flat view
    SphereRange range;         ///< of a sphere
    std::string ods_eye;       ///< of a sphere of omnidirectional stereo: "ods_left" or "ods_right"; else empty
    double ods_ipd = 0;        ///< of such a one, in the XML's unit
};

struct SceneRequest {
    std::filesystem::path xml;
    std::vector<std::pair<std::string, std::string>> parameters;  ///< -D name=value
    int sensor = 0;                                               ///< which of the XML's sensors tells where to begin
    std::string aovs;                                             ///< groups; "none": colour alone
    int max_depth = 0;  ///< above 0: of the XML's integrator, in the place of its own
    std::vector<SensorRequest> sensors;
};

/// What the XML says of the sensor that ours take the place of.
struct XmlSensor {
    Matrix34 to_world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< from its camera frame: +X left, +Y up, +Z forward
    int count = 0;                                          ///< sensors in the XML; with none this one is the default
    bool has_pose = false;                                  ///< by to_world
    /// Of flat views along their axis, of spheres along rays; in the XML's unit. As given, else our sensors' defaults.
    double near_clip = 0, far_clip = std::numeric_limits<double>::infinity();
    bool has_clips = false;                    ///< one of them is given
    std::vector<std::filesystem::path> files;  ///< the XML's and those it includes and names, as far as they exist
    std::string spectra;                       ///< what was read from files of spectra
};

/// Where a camera is at the frame and at its neighbours.
struct CameraPlacement {
    Matrix34 previous, now, next;
    std::optional<SphereRange> range{};  ///< of a sphere, where it is another one than the frame before's
};

/// A shape of the scene, in the order of the integrator's tables.
struct ShapeSummary {
    std::string id, class_name;  ///< ids are unique, given or not
    int group = -1;              ///< of an instance: index of its shape group in groups()
    Matrix34 to_world{};         ///< of an instance and of shapes that are not meshes
    bool is_mesh = false;        ///< vertices are known, in world space (in the group's, below a group)
    std::string bsdf;            ///< id of its material
    bool is_invisible = false;   ///< only there to bound a medium, or a lamp that is looked through
};

struct ShapeGroup {
    std::string id;
    std::vector<ShapeSummary> shapes;
};

/// Of a mesh; normals and texture coordinates may be empty.
struct MeshBuffers {
    std::vector<float> positions, normals, texture_coordinates;
    std::vector<std::uint32_t> triangles;
};

/// Opacity of a material that cuts holes, over texture coordinates [0, 1)^2, row y at v = (y + 1/2) / height.
struct OpacityMap {
    int width = 0, height = 0;
    std::vector<float> opacity;
};

/// What one pass leaves: all channels of a pixel together, rows from the top.
struct PassResult {
    std::vector<std::string> channels;  ///< "R", "G", "B", "A", then those of the AOVs
    std::vector<float> values;
    std::vector<float> guides;  ///< guide_channels of each pixel, where they were asked for
};

/// A denoiser's: albedo and normal (es_tile_put_guides), in Mitsuba's world.
inline constexpr std::size_t guide_channels = 6;

/// Tables of the AOV integrator: an entry for each shape, then those that triangles of merged meshes have instead.
struct ShapeIds {
    std::vector<std::uint32_t> object, material, instance;
    /// By shape: from which place on face_entry has its triangles, plus 1; 0: the shape's own entry counts.
    std::vector<std::uint32_t> first_face;
    std::vector<std::uint32_t> face_entry;
};

/// The object of what is no surface to us but is one to Mitsuba: our sun's disc.
inline constexpr std::uint32_t no_surface_id = 0xfffffe;

/// Rays that no sensor made; directions are unit, distances from the origins.
struct RayBatch {
    std::array<std::vector<float>, 3> origin, direction;
    std::vector<float> begin, end;  ///< end: +inf for no end

    std::size_t size() const { return begin.size(); }
};

class EmbeddedScene {
public:
    /// Parses the XML, puts our sensors and our integrator in the place of its own, and builds it. A fault in the XML
    /// is an InputError in Mitsuba's words.
    static std::unique_ptr<EmbeddedScene> load(const Engine& engine, const SceneRequest& request);
    virtual ~EmbeddedScene() = default;

    virtual const XmlSensor& xml_sensor() const = 0;
    virtual const std::vector<ShapeSummary>& shapes() const = 0;
    virtual const std::vector<ShapeGroup>& groups() const = 0;

    /// Of a shape of the scene (group < 0) or of a group.
    virtual MeshBuffers mesh(int group, std::size_t shape) = 0;
    /// Width 0 where the shape's material cuts no holes.
    virtual OpacityMap opacity(int group, std::size_t shape) = 0;

    /// Which placement each triangle of a merged mesh is of, by attribute face_instance; empty for other shapes.
    virtual std::vector<std::uint32_t> face_instances(std::size_t shape) = 0;

    virtual void set_ids(const ShapeIds& ids) = 0;
    /// 12 numbers a shape, as Matrix34: from a point now to where it is in the neighbour frame. Empty: nothing moves.
    virtual void set_moved(const std::vector<float>& previous, const std::vector<float>& next) = 0;
    /// Of an instance.
    virtual void place_instance(std::size_t shape, const Matrix34& world_from_group) = 0;
    /// Of a mesh; normals are computed anew unless given.
    virtual void place_vertices(std::size_t shape, const std::vector<float>& positions,
                                const std::vector<float>& normals) = 0;
    /// After any of the two.
    virtual void commit_placements() = 0;

    virtual void place_camera(std::size_t sensor, const CameraPlacement& placement) = 0;
    /// Renders `samples` a pixel; without AOVs colour alone.
    virtual PassResult render(std::size_t sensor, std::uint32_t samples, std::uint32_t seed, bool aovs,
                              bool guides) = 0;

    /// How far each ray goes to the first visible surface; +inf for a miss.
    virtual std::vector<float> distances(const RayBatch& rays) = 0;
    /// guide_channels of each ray.
    virtual std::vector<float> guides(const RayBatch& rays) = 0;
    /// Object and material of what each ray meets first, two numbers a ray; 0 for a miss.
    virtual std::vector<std::uint32_t> ids(const RayBatch& rays) = 0;
    /// One sample of what comes along each ray, by the XML's integrator, beginning in the medium of this sensor:
    /// linear Rec.709 R, G, B, and 1 where the ray meets a surface, else 0.
    virtual std::vector<float> radiance(const RayBatch& rays, std::size_t sensor, std::uint32_t seed) = 0;
};

}  // namespace equistream::mitsuba_host
