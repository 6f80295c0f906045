#pragma once
/// What the AOV integrator knows of a sensor: its image formula and its poses, read from the parameters that the sensor
/// exposes, because plugins cannot include each other's classes.
#include "parameters.h"
#include "rigid_pose.h"

#include <equistream/image_motion.h>

#include <mitsuba/render/film.h>
#include <mitsuba/render/sensor.h>

#include <string>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
struct SensorView {
    MI_IMPORT_CORE_TYPES()
    using Sensor = mitsuba::Sensor<Float, Spectrum>;

    bool sphere = true;
    AffineTransform4f to_world, to_world_previous, to_world_next;
    ScalarVector2u size, crop_size;
    ScalarPoint2u crop_offset;
    LongitudeLatitudeRange range;
    /// Half the interpupillary distance of omnidirectional stereo, signed, or else 0.
    ScalarFloat ods_side = 0;
    PoleMerge pole_merge;
    /// Where an eye is in Mitsuba's camera frame.
    ScalarVector3f eye_offset{0, 0, 0};
    /// How far from that place a sphere's rays begin.
    ScalarFloat near_clip = 0;
    /// Perspective: focal length, and where the optical axis is off the image's middle, in pixels.
    Float focal_px = 0.f;
    ScalarVector2f principal_px{0, 0};

    /// Throws one line for a sensor whose formula is not known.
    SensorView(Sensor* sensor)
        : size(sensor->film()->size()), crop_size(sensor->film()->crop_size()),
          crop_offset(sensor->film()->crop_offset()) {
        const Parameters values(*sensor);
        const std::string kind(sensor->class_name());
        if (kind == "EquirectSensor")
            read_sphere(values);
        else if (kind == "PerspectiveCamera" || kind == "ThinLensCamera")
            read_perspective(values);
        else
            refuse("equirect_aov: expected a sensor \"equirect\", \"perspective\" or \"thinlens\", found %s", kind);
    }

    /// How far from the sensor's own place this ray of it begins: Mitsuba's sensors begin theirs at the near plane.
    Float distance_before(const Point3f& ray_origin) const {
        if (sphere)
            return near_clip;
        return dr::norm(ray_origin - centre(to_world));
    }

    Point3f centre(const AffineTransform4f& pose) const { return pose * Point3f(Vector3f(eye_offset)); }

    /// Motion from a pixel to where a world point is in the image that `there` takes.
    Vector2f motion_of_point(const PixelCoordinates<Float>& here, const Point3f& world,
                             const AffineTransform4f& there) const {
        const Vector3f local = there.inverse() * Vector3f(world - centre(there));
        const Vector3<Float> d = contract_frame<Float>(local);
        return motion(here, ods_side != 0 ? ods_direction(d, double(ods_side), pole_merge) : d);
    }

    /// Of what is infinitely far away in this direction: only the camera's turning moves it.
    Vector2f motion_of_direction(const PixelCoordinates<Float>& here, const Vector3f& world,
                                 const AffineTransform4f& there) const {
        return motion(here, contract_frame<Float>(Vector3f(there.inverse() * world)));
    }

private:
    Vector2f motion(const PixelCoordinates<Float>& here, const Vector3<Float>& direction) const {
        const int width = int(size.x()), height = int(size.y());
        PixelCoordinates<Float> m;
        if (sphere)
            m = equirect_motion(here, direction, width, height, range);
        else
            m = perspective_motion(PixelCoordinates<Float>{here.u + principal_px.x(), here.v + principal_px.y()},
                                   direction, width, height, focal_px);
        return Vector2f(m.u, m.v);
    }

    template <typename T>
    static const T& value(const Parameters& values, const char* name) {
        if (const T* found = values.find<T>(name))
            return *found;
        refuse("equirect_aov: expected the sensor to expose \"%s\", found nothing of that name and type", name);
    }

    void read_sphere(const Parameters& values) {
        to_world = value<AffineTransform4f>(values, "to_world");
        to_world_previous = value<AffineTransform4f>(values, "to_world_previous");
        to_world_next = value<AffineTransform4f>(values, "to_world_next");
        const double rad = pi / 180;
        range = {value<ScalarFloat>(values, "longitude_min") * rad, value<ScalarFloat>(values, "longitude_max") * rad,
                 value<ScalarFloat>(values, "latitude_min") * rad, value<ScalarFloat>(values, "latitude_max") * rad};
        const auto eye = value<uint32_t>(values, "eye");
        const ScalarFloat half = value<ScalarFloat>(values, "ipd") / 2;
        const ScalarFloat side = eye == 0 ? 0.f : eye % 2 == 1 ? -half : half;
        if (eye >= 3)
            ods_side = side;
        else
            eye_offset = ScalarVector3f(-side, 0, 0);
        near_clip = value<ScalarFloat>(values, "near_clip");
        pole_merge = {value<ScalarFloat>(values, "ods_merge_from") * rad,
                      value<ScalarFloat>(values, "ods_merge_to") * rad};
        if (!value<bool>(values, "ods_pole_merges"))
            pole_merge = {pi, pi};
    }

    void read_perspective(const Parameters& values) {
        sphere = false;
        to_world = to_world_previous = to_world_next = value<AffineTransform4f>(values, "to_world");
        const Float fov = value<Float>(values, "x_fov") * Float(pi / 180);
        focal_px = Float(0.5 * size.x()) / dr::tan(0.5f * fov);
        if (const Float* x = values.find<Float>("principal_point_offset_x"))
            principal_px.x() = host(*x) * ScalarFloat(size.x());
        if (const Float* y = values.find<Float>("principal_point_offset_y"))
            principal_px.y() = host(*y) * ScalarFloat(size.y());
    }

    static ScalarFloat host(const Float& x) { return dr::slice<ScalarFloat>(x); }
};

}  // namespace equistream::mitsuba_host
