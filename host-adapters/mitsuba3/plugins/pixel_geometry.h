#pragma once
/// The geometry planes of one pixel, or of an array of pixels: what one unfiltered ray through its centre sees.
#include "appearance.h"
#include "first_surface.h"
#include "sensor_view.h"

#include <equistream/aov.h>
#include <equistream/virtual_image.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace equistream::mitsuba_host {

/// What the user gave for each shape of the scene, in its order; tables that are empty or a single 0 stand for their
/// defaults. They begin as a single 0: scalar variants in Python cannot replace an empty array.
template <typename Float>
struct ShapeTables {
    using UInt32 = dr::uint32_array_t<Float>;
    mitsuba::DynamicBuffer<UInt32> object_id, material_id, instance_id;
    /// Of meshes whose triangles have ids of their own: by shape, from which place on face_entry has them, plus 1, or
    /// 0; and which entry of the three tables each triangle has.
    mitsuba::DynamicBuffer<UInt32> first_face, face_entry;
    /// Twelve numbers each: the rows of the 3x4 matrix that takes a world point to where it is in the other frame.
    mitsuba::DynamicBuffer<Float> moved_previous, moved_next;

    DRJIT_STRUCT(ShapeTables, object_id, material_id, instance_id, first_face, face_entry, moved_previous, moved_next)
};

template <typename Float, typename Spectrum>
class PixelGeometry {
public:
    MI_IMPORT_TYPES(Scene, Sensor, BSDFPtr)
    using Facts = ShapeFacts<Float, Spectrum>;
    using View = SensorView<Float, Spectrum>;

    /// All of it is only referred to. `entries`: of the tables of ids that are no defaults.
    PixelGeometry(const Scene* scene, const Sensor* sensor, const View& view, const Facts& facts,
                  const ShapeTables<Float>& tables, std::uint32_t entries,
                  const Appearance<Float, Spectrum>& appearance)
        : scene_(scene), sensor_(sensor), view_(view), facts_(facts), tables_(tables), entries_(entries),
          appearance_(appearance) {}

    /// The channels of these planes, in their order, for pixel (x, y) of the crop window. Threads may share this.
    void put(const std::vector<std::string>& planes, const UInt32& x, const UInt32& y, Float* out) const {
        const bool any_virtual = std::any_of(
            planes.begin(), planes.end(), [](const std::string& plane) { return find_aov(plane)->group == "virtual"; });
        const Seen seen(*this, x, y, any_virtual);
        for (const std::string& plane : planes)
            out = put_plane(plane, seen, out);
    }

private:
    /// One pixel's ray and what it met. In scalar variants a miss has no BSDF that could be asked.
    struct Seen {
        PixelCoordinates<Float> pixel;
        RayDifferential3f ray;
        Float distance;
        SurfaceInteraction3f si;
        Mask hit;
        BSDFPtr bsdf = nullptr;
        UInt32 shape;  ///< index in the scene's list
        /// What shows in the surface, where that may be sharp and somebody asks.
        std::optional<SharpPath<Float, Spectrum>> within;

        Seen(const PixelGeometry& of, const UInt32& x, const UInt32& y, bool looks_within) {
            const Point2f centre(Float(x) + 0.5f, Float(y) + 0.5f);
            pixel = {centre.x() + ScalarFloat(of.view_.crop_offset.x()),
                     centre.y() + ScalarFloat(of.view_.crop_offset.y())};
            const ScalarFloat time = of.sensor_->shutter_open() + 0.5f * of.sensor_->shutter_open_time();
            // The middle of an aperture is the pinhole.
            ray = of.sensor_
                      ->sample_ray_differential(time, 0.5f, centre / ScalarVector2f(of.view_.crop_size), Point2f(0.5f))
                      .first;
            const FirstSurface<Float, Spectrum> surface(of.scene_, ray, of.facts_, true);
            si = surface.si;
            hit = si.is_valid();
            const Float before = of.view_.distance_before(ray.o);
            distance = surface.distance + before;
            if (any())
                bsdf = si.bsdf();
            if (looks_within && of.facts_.any_sharp() && any())
                within.emplace(of.scene_, of.facts_, of.appearance_, ray, before, hit);
            shape = of.facts_.index(si.shape, si.instance, hit);
        }
        bool any() const { return dr::any_or<true>(hit); }
    };

    Float* put_plane(const std::string& plane, const Seen& seen, Float* out) const {
        if (plane == "depth")
            *out++ = seen.distance;
        else if (plane == "albedo")
            out = put_three(albedo(seen), out);
        else if (plane == "normal")
            out = put_three(normal(seen), out);
        else if (plane == "backward")
            out = put_two(motion(seen, tables_.moved_previous, view_.to_world_previous), out);
        else if (plane == "forward")
            out = put_two(motion(seen, tables_.moved_next, view_.to_world_next), out);
        else if (plane == "virtual_depth")
            *out++ = seen.within ? Float(dr::select(seen.within->is_sharp, seen.within->distance, seen.distance))
                                 : seen.distance;
        else if (plane == "virtual_backward")
            out = put_two(motion_within(seen, tables_.moved_previous, view_.to_world_previous), out);
        else if (plane == "virtual_forward")
            out = put_two(motion_within(seen, tables_.moved_next, view_.to_world_next), out);
        else if (plane == "object_id")
            out = put_id(seen, tables_.object_id, seen.shape + 1u, out);
        else if (plane == "material_id")
            out = put_id(seen, tables_.material_id, facts_.material(seen.si.shape, seen.hit), out);
        else if (plane == "instance_id")
            out = put_id(seen, tables_.instance_id, seen.shape + 1u, out);
        else if (plane == "specular")
            *out++ = specular(seen);
        return out;
    }

    template <typename Three>
    static Float* put_three(const Three& values, Float* out) {
        for (size_t c = 0; c < 3; ++c)
            *out++ = values[c];
        return out;
    }

    Color3f albedo(const Seen& seen) const {
        if (!seen.any())
            return Color3f(0.f);
        return appearance_.albedo(seen.bsdf, seen.si, facts_.any_without_diffuse(), seen.hit);
    }

    Vector3f normal(const Seen& seen) const {
        if (!seen.any())
            return Vector3f(0.f);
        const auto own = [](const auto& v) { return Vector3<Float>{v.x(), v.y(), v.z()}; };
        const Vector3f viewer = -seen.ray.d;
        const Vector3f geometric = dr::mulsign(Vector3f(seen.si.n), dr::dot(seen.si.n, viewer));
        const Vector3<Float> n =
            visible_normal(own(seen.bsdf->sh_frame(seen.si, seen.hit).n), own(geometric), own(viewer));
        return dr::select(seen.hit, Vector3f(n.x, n.y, n.z), Vector3f(0.f));
    }

    Float specular(const Seen& seen) const {
        if (!facts_.any_sharp() || !seen.any())
            return Float(0.f);
        return dr::select(appearance_.sharp_lobe(seen.bsdf, seen.si, seen.hit).sharp, Float(1.f), Float(0.f));
    }

    /// Ids below 2^24 are exact in a film's floats.
    Float* put_id(const Seen& seen, const mitsuba::DynamicBuffer<UInt32>& given, const UInt32& otherwise,
                  Float* out) const {
        UInt32 id = otherwise;
        if (dr::width(given) >= entries_) {
            const UInt32 wanted = dr::gather<UInt32>(given, entry(seen), seen.hit);
            id = dr::select(wanted != 0u, wanted, otherwise);
        }
        *out++ = dr::select(seen.hit, Float(id), Float(0.f));
        return out;
    }

    /// In the tables of ids.
    UInt32 entry(const Seen& seen) const {
        if (dr::width(tables_.first_face) != facts_.count() || dr::width(tables_.face_entry) == 0)
            return seen.shape;
        const UInt32 first = dr::gather<UInt32>(tables_.first_face, seen.shape, seen.hit);
        const Mask by_face = seen.hit && first != 0u;
        // Never beyond the table, whatever somebody filled it with.
        const UInt32 place = dr::minimum(first - 1u + UInt32(seen.si.prim_index),
                                         UInt32(std::uint32_t(dr::width(tables_.face_entry) - 1)));
        const UInt32 of_face = dr::gather<UInt32>(tables_.face_entry, place, by_face);
        return dr::select(by_face, of_face, seen.shape);
    }

    static Float* put_two(const Vector2f& values, Float* out) {
        *out++ = values.x();
        *out++ = values.y();
        return out;
    }

    /// Where a point of a shape is in the other frame.
    Point3f moved_point(const Point3f& p, const UInt32& shape, const mitsuba::DynamicBuffer<Float>& moved,
                        const Mask& active) const {
        if (dr::width(moved) != 12 * facts_.count())
            return p;
        std::array<Float, 12> m;
        for (uint32_t k = 0; k < 12; ++k)
            m[k] = dr::gather<Float>(moved, shape * 12u + k, active);
        Point3f there;
        for (size_t row = 0; row < 3; ++row)
            there[row] = dr::fmadd(m[4 * row], p.x(),
                                   dr::fmadd(m[4 * row + 1], p.y(), dr::fmadd(m[4 * row + 2], p.z(), m[4 * row + 3])));
        return there;
    }

    Vector2f motion(const Seen& seen, const mitsuba::DynamicBuffer<Float>& moved,
                    const AffineTransform4f& there) const {
        const Point3f p = moved_point(seen.si.p, seen.shape, moved, seen.hit);
        return dr::select(seen.hit, view_.motion_of_point(seen.pixel, p, there),
                          view_.motion_of_direction(seen.pixel, seen.ray.d, there));
    }

    Vector2f motion_within(const Seen& seen, const mitsuba::DynamicBuffer<Float>& moved,
                           const AffineTransform4f& there) const {
        const Vector2f without = motion(seen, moved, there);
        if (!seen.within)
            return without;
        const auto& within = *seen.within;
        const Point3f p = moved_point(within.seen, within.shape, moved, within.ends);
        const Vector3f movement = dr::select(within.ends, Vector3f(p - within.seen), Vector3f(0.f));
        const Mask near = dr::isfinite(within.distance);
        const Vector2f of_image =
            dr::select(near, view_.motion_of_point(seen.pixel, within.image_moved(movement), there),
                       view_.motion_of_direction(seen.pixel, seen.ray.d, there));
        return dr::select(within.is_sharp, of_image, without);
    }

    const Scene* scene_;
    const Sensor* sensor_;
    const View& view_;
    const Facts& facts_;
    const ShapeTables<Float>& tables_;
    std::uint32_t entries_;
    const Appearance<Float, Spectrum>& appearance_;
};

}  // namespace equistream::mitsuba_host
