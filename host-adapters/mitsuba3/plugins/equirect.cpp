/**!

.. _sensor-equirect:

Spherical camera (:monosp:`equirect`)
-------------------------------------

.. pluginparameters::

 * - to_world
   - |transform|
   - Pose of the head, in Mitsuba's camera frame: +Z forward, +Y up, +X left. Scale, shear and mirroring are
     errors. (Default: none, i.e. camera space = world space)
   - |exposed|

 * - to_world_previous, to_world_next
   - |transform|
   - The same for the frame before and the frame after, for motion (integrator :monosp:`equirect_aov`). Without
     it the camera does not move. (Default: ``to_world``)
   - |exposed|

 * - eye
   - |string|
   - ``centre``; ``left`` or ``right``: half the ``ipd`` along the head's X axis; ``ods_left`` or ``ods_right``:
     omnidirectional stereo. Exposed as the index 0 to 4 in this order. (Default: ``centre``)
   - |exposed|

 * - ipd
   - |float|
   - Interpupillary distance in the scene's unit. (Default: 0.063)
   - |exposed|

 * - longitude_min, longitude_max
   - |float|
   - The range of the image's columns in degrees: 0 forward, positive to the right. (Default: -180, 180)
   - |exposed|

 * - latitude_min, latitude_max
   - |float|
   - The range of the image's rows in degrees: +90 straight up and at the top row. (Default: -90, 90)
   - |exposed|

 * - ods_pole
   - |string|
   - ``merge``: the eyes of omnidirectional stereo come together towards the poles; ``none``: they do not.
     Exposed as ``ods_pole_merges``, true or false. (Default: ``merge``)
   - |exposed|

 * - ods_merge_from, ods_merge_to
   - |float|
   - Between these latitudes, in degrees, the separation fades from ``ipd`` to 0. (Default: 60, 75)
   - |exposed|

 * - near_clip, far_clip
   - |float|
   - Surfaces nearer or farther than this are not seen. Both are distances from the eye, not along an axis. Depth is
     still measured from the eye. (Default: 0, infinity)
   - |exposed|

 * - shutter_open, shutter_close, srf
   - |float|, |spectrum|
   - As for every Mitsuba sensor.

 * - (Nested plugin)
   - |film|, |sampler|
   - As for every Mitsuba sensor. Any width, height and crop window. A full sphere that is not 2:1 has pixels that are
     not square on the equator, which is noted in the log.

The whole sphere, or a range of it, as one image. With longitude :math:`l` and latitude :math:`p`

.. math::

    u = (l / 2\pi + 1/2) W, \qquad v = (1/2 - p / \pi) H, \qquad
    d = (\cos p \sin l, \; \sin p, \; -\cos p \cos l)

in a frame with +X to the right, +Y up and -Z forward. Pixel centres are at half-integers. The middle of the image is
forward. A quarter of the width to its right is the right-hand side. Column W is column 0, and the top row is up. The
image is not mirrored. These formulas are those in equistream's conventions.h, compiled for this variant.

In omnidirectional stereo each column has its own viewpoint, on a circle of radius ipd/2 around the head. Its rays leave
that circle along the tangent. Depth is measured from the column's own viewpoint. The radius is multiplied by :math:`(1
+ \cos \pi t)/2` with :math:`t = (|p| - from)/(to - from)`: see image_motion.h.

.. tabs::
    .. code-tab:: xml

        <sensor type="equirect">
            <float name="near_clip" value="0.1"/>
            <transform name="to_world">
                <lookat origin="0, 1.6, 0" target="0, 1.6, -1" up="0, 1, 0"/>
            </transform>
            <film type="hdrfilm">
                <integer name="width" value="1920"/>
                <integer name="height" value="960"/>
                <string name="component_format" value="float32"/>
                <rfilter type="box"/>
            </film>
        </sensor>

    .. code-tab:: python

        # VR180 for the left eye
        'type': 'equirect',
        'eye': 'left',
        'longitude_min': -90., 'longitude_max': 90.,
        'to_world': mi.ScalarTransform4f().look_at(origin=[0, 1.6, 0], target=[0, 1.6, -1], up=[0, 1, 0]),
        'film': {'type': 'hdrfilm', 'width': 960, 'height': 960, 'rfilter': {'type': 'box'}}

Limits:

- Light tracing (:monosp:`ptracer`) is refused in one line when it begins: paths start at this sensor.
- No depth of field, no motion blur of the camera: the pose is one for the whole exposure.
- Nothing is differentiable with respect to the sensor's parameters.
- A reconstruction filter does not reach across the seam: column W-1 gets nothing from samples of column 0.
- A point that lies inside the viewing circle cannot be seen tangentially: omnidirectional stereo leaves it out.
 */

#include "registration.h"
#include "rigid_pose.h"

#include <equistream/image_motion.h>

#include <mitsuba/core/properties.h>
#include <mitsuba/render/film.h>
#include <mitsuba/render/sensor.h>

#include <algorithm>
#include <array>

NAMESPACE_BEGIN(mitsuba)

template <typename Float, typename Spectrum>
class EquirectSensor final : public Sensor<Float, Spectrum> {
public:
    MI_IMPORT_BASE(Sensor, m_film, m_needs_sample_3, m_resolution, m_to_world, sample_wavelengths)
    MI_IMPORT_TYPES()

    EquirectSensor(const Properties& props) : Base(props) {
        m_eye = index_of(eyes, props.get<std::string_view>("eye", "centre"), "eye");
        m_ipd = props.get<ScalarFloat>("ipd", 0.063f);
        m_longitude_min = props.get<ScalarFloat>("longitude_min", -180.f);
        m_longitude_max = props.get<ScalarFloat>("longitude_max", 180.f);
        m_latitude_min = props.get<ScalarFloat>("latitude_min", -90.f);
        m_latitude_max = props.get<ScalarFloat>("latitude_max", 90.f);
        m_pole_merges = index_of(pole_treatments, props.get<std::string_view>("ods_pole", "merge"), "ods_pole") == 0;
        m_merge_from = props.get<ScalarFloat>("ods_merge_from", 60.f);
        m_merge_to = props.get<ScalarFloat>("ods_merge_to", 75.f);
        m_near_clip = props.get<ScalarFloat>("near_clip", 0.f);
        m_far_clip = props.get<ScalarFloat>("far_clip", dr::Infinity<ScalarFloat>);
        m_has_previous = props.has_property("to_world_previous");
        m_has_next = props.has_property("to_world_next");
        if (m_has_previous)
            m_previous = props.get<ScalarAffineTransform4f>("to_world_previous");
        if (m_has_next)
            m_next = props.get<ScalarAffineTransform4f>("to_world_next");
        m_needs_sample_3 = false;
        update();
        const ScalarVector2u size = m_film->size();
        if (range().is_full_sphere() && size.x() != 2 * size.y())
            Log(Info, "equirect: a full sphere of %ux%u pixels is not 2:1, so pixels are not square on the equator",
                size.x(), size.y());
    }

    void traverse(TraversalCallback* cb) override {
        Base::traverse(cb);
        cb->put("to_world", m_to_world, ParamFlags::NonDifferentiable);
        cb->put("to_world_previous", m_previous, ParamFlags::NonDifferentiable);
        cb->put("to_world_next", m_next, ParamFlags::NonDifferentiable);
        cb->put("eye", m_eye, ParamFlags::NonDifferentiable);
        cb->put("ipd", m_ipd, ParamFlags::NonDifferentiable);
        cb->put("longitude_min", m_longitude_min, ParamFlags::NonDifferentiable);
        cb->put("longitude_max", m_longitude_max, ParamFlags::NonDifferentiable);
        cb->put("latitude_min", m_latitude_min, ParamFlags::NonDifferentiable);
        cb->put("latitude_max", m_latitude_max, ParamFlags::NonDifferentiable);
        cb->put("ods_pole_merges", m_pole_merges, ParamFlags::NonDifferentiable);
        cb->put("ods_merge_from", m_merge_from, ParamFlags::NonDifferentiable);
        cb->put("ods_merge_to", m_merge_to, ParamFlags::NonDifferentiable);
        cb->put("near_clip", m_near_clip, ParamFlags::NonDifferentiable);
        cb->put("far_clip", m_far_clip, ParamFlags::NonDifferentiable);
    }

    void parameters_changed(const std::vector<std::string>& keys) override {
        Base::parameters_changed(keys);
        // What is written through a traversal lacks the inverse, and its host copy.
        const auto written = [&](const char* key) { return keys.empty() || string::contains(keys, key); };
        if (written("to_world"))
            m_to_world = m_to_world.value().update();
        if (string::contains(keys, "to_world_previous"))
            m_has_previous = true;
        if (string::contains(keys, "to_world_next"))
            m_has_next = true;
        if (m_has_previous && written("to_world_previous"))
            m_previous = m_previous.value().update();
        if (m_has_next && written("to_world_next"))
            m_next = m_next.value().update();
        update();
    }

    std::pair<Ray3f, Spectrum> sample_ray(Float time, Float wavelength_sample, const Point2f& position_sample,
                                          const Point2f& /*aperture_sample*/, Mask active) const override {
        MI_MASKED_FUNCTION(ProfilerPhase::EndpointSampleRay, active);
        auto [wavelengths, weight] = sample_wavelengths(dr::zeros<SurfaceInteraction3f>(), wavelength_sample, active);
        const ScalarVector2u size = m_film->size();
        const auto d = equistream::equirect_direction(pixel(position_sample), (int)size.x(), (int)size.y(), range());
        Ray3f ray;
        ray.time = time;
        ray.wavelengths = wavelengths;
        ray.d = m_to_world.value() * equistream::mitsuba_host::mitsuba_frame<Vector3f>(d);
        ray.o = m_to_world.value() * Point3f(eye_position(d));
        begin_at_near_clip(ray);
        return {ray, weight};
    }

    std::pair<RayDifferential3f, Spectrum> sample_ray_differential(Float time, Float wavelength_sample,
                                                                   const Point2f& position_sample,
                                                                   const Point2f& /*aperture_sample*/,
                                                                   Mask active) const override {
        MI_MASKED_FUNCTION(ProfilerPhase::EndpointSampleRay, active);
        using equistream::mitsuba_host::mitsuba_frame;
        auto [wavelengths, weight] = sample_wavelengths(dr::zeros<SurfaceInteraction3f>(), wavelength_sample, active);
        const ScalarVector2u size = m_film->size();
        const auto d =
            equistream::equirect_direction_derivatives(pixel(position_sample), (int)size.x(), (int)size.y(), range());
        RayDifferential3f ray;
        ray.time = time;
        ray.wavelengths = wavelengths;
        ray.d = m_to_world.value() * mitsuba_frame<Vector3f>(d.direction);
        ray.o = m_to_world.value() * Point3f(eye_position(d.direction));
        begin_at_near_clip(ray);
        // An ODS eye moves by at most ipd/2 times a pixel's angle from one column to the next: nothing to a texture
        // filter.
        ray.o_x = ray.o_y = ray.o;
        ray.d_x = ray.d + m_to_world.value() * mitsuba_frame<Vector3f>(d.per_column);
        ray.d_y = ray.d + m_to_world.value() * mitsuba_frame<Vector3f>(d.per_row);
        ray.has_differentials = true;
        return {ray, weight};
    }

    std::pair<DirectionSample3f, Spectrum> sample_direction(const Interaction3f&, const Point2f&, Mask) const override {
        equistream::mitsuba_host::refuse(
            "equirect: light tracing (integrators such as \"ptracer\") cannot begin at the lights with this sensor: "
            "expected an integrator that begins at the camera, such as \"path\"");
    }

    ScalarBoundingBox3f bbox() const override {
        const ScalarPoint3f centre = m_to_world.scalar() * ScalarPoint3f(0.f);
        const ScalarFloat reach = m_eye == Centre ? 0.f : m_ipd / 2;
        return ScalarBoundingBox3f(centre - reach, centre + reach);
    }

    std::string to_string() const override {
        std::ostringstream oss;
        oss << "EquirectSensor[" << std::endl
            << "  eye = " << eyes[m_eye] << "," << std::endl
            << "  ipd = " << m_ipd << "," << std::endl
            << "  longitude = [" << m_longitude_min << ", " << m_longitude_max << "]," << std::endl
            << "  latitude = [" << m_latitude_min << ", " << m_latitude_max << "]," << std::endl
            << "  near_clip = " << m_near_clip << "," << std::endl
            << "  far_clip = " << m_far_clip << "," << std::endl
            << "  film = " << string::indent(m_film) << "," << std::endl
            << "  to_world = " << string::indent(m_to_world, 13) << std::endl
            << "]";
        return oss.str();
    }

    MI_DECLARE_CLASS(EquirectSensor)

private:
    enum Eye : uint32_t { Centre, Left, Right, OdsLeft, OdsRight };
    static constexpr std::array<std::string_view, 5> eyes = {"centre", "left", "right", "ods_left", "ods_right"};
    static constexpr std::array<std::string_view, 2> pole_treatments = {"merge", "none"};

    template <size_t Count>
    static uint32_t index_of(const std::array<std::string_view, Count>& names, std::string_view word,
                             const char* property) {
        const auto at = std::find(names.begin(), names.end(), word);
        if (at != names.end())
            return (uint32_t)(at - names.begin());
        std::string accepted;
        for (const std::string_view name : names)
            accepted += (accepted.empty() ? "" : ", ") + std::string(name);
        equistream::mitsuba_host::refuse("equirect: %s: expected one of %s, found \"%s\"", property, accepted, word);
    }

    equistream::LongitudeLatitudeRange range() const {
        const double rad = equistream::pi / 180;
        return {m_longitude_min * rad, m_longitude_max * rad, m_latitude_min * rad, m_latitude_max * rad};
    }

    equistream::PoleMerge pole_merge() const {
        if (!m_pole_merges)
            return {equistream::pi, equistream::pi};
        return {m_merge_from * equistream::pi / 180, m_merge_to * equistream::pi / 180};
    }

    /// Half the interpupillary distance, signed: right is positive.
    ScalarFloat side() const {
        const bool left = m_eye == Left || m_eye == OdsLeft;
        return m_eye == Centre ? 0.f : left ? -m_ipd / 2 : m_ipd / 2;
    }

    equistream::PixelCoordinates<Float> pixel(const Point2f& position_sample) const {
        const ScalarVector2f size(m_film->crop_size());
        const ScalarPoint2f offset(m_film->crop_offset());
        return {dr::fmadd(position_sample.x(), size.x(), offset.x()),
                dr::fmadd(position_sample.y(), size.y(), offset.y())};
    }

    /// In Mitsuba's camera frame.
    Vector3f eye_position(const equistream::Vector3<Float>& direction) const {
        using equistream::mitsuba_host::mitsuba_frame;
        if (m_eye == Centre)
            return Vector3f(0.f);
        if (m_eye == Left || m_eye == Right)
            return Vector3f(-side(), 0.f, 0.f);
        return mitsuba_frame<Vector3f>(equistream::ods_eye_offset(
            equistream::longitude_of(direction), equistream::latitude_of(direction), (double)side(), pole_merge()));
    }

    /// Mitsuba's rays have no least distance: they begin there, and whoever measures depth adds it again.
    template <typename Ray>
    void begin_at_near_clip(Ray& ray) const {
        if (m_near_clip > 0)
            ray.o = dr::fmadd(ray.d, m_near_clip, ray.o);
        if (dr::isfinite(m_far_clip))
            ray.maxt = m_far_clip - m_near_clip;
    }

    static void check(bool holds, const char* property, const char* expected, double found) {
        if (!holds)
            equistream::mitsuba_host::refuse("equirect: %s: expected %s, found %g", property, expected, found);
    }

    /// Called whenever a parameter may have changed.
    void update() {
        check(m_eye < eyes.size(), "eye", "an index from 0 to 4", m_eye);
        check(m_ipd >= 0 && m_ipd < dr::Infinity<ScalarFloat>, "ipd", "a distance of 0 or more", m_ipd);
        check(m_longitude_min < m_longitude_max, "longitude_max", "more than longitude_min", m_longitude_max);
        check(m_longitude_max - m_longitude_min <= 360.f, "longitude_max", "at most longitude_min + 360",
              m_longitude_max);
        check(m_longitude_min >= -360.f, "longitude_min", "-360 or more", m_longitude_min);
        check(m_longitude_max <= 360.f, "longitude_max", "360 or less", m_longitude_max);
        check(m_latitude_min >= -90.f, "latitude_min", "-90 or more", m_latitude_min);
        check(m_latitude_min < m_latitude_max, "latitude_max", "more than latitude_min", m_latitude_max);
        check(m_latitude_max <= 90.f, "latitude_max", "90 or less", m_latitude_max);
        check(m_merge_from >= 0, "ods_merge_from", "0 or more", m_merge_from);
        check(m_merge_from < m_merge_to, "ods_merge_to", "more than ods_merge_from", m_merge_to);
        check(m_merge_to <= 90.f, "ods_merge_to", "90 or less", m_merge_to);
        check(m_near_clip >= 0 && m_near_clip < dr::Infinity<ScalarFloat>, "near_clip", "a distance of 0 or more",
              m_near_clip);
        check(m_near_clip < m_far_clip, "far_clip", "more than near_clip", m_far_clip);
        if (!m_has_previous)
            m_previous = m_to_world.scalar();
        if (!m_has_next)
            m_next = m_to_world.scalar();
        equistream::mitsuba_host::require_rigid(m_to_world.scalar(), "equirect", "to_world");
        equistream::mitsuba_host::require_rigid(m_previous.scalar(), "equirect", "to_world_previous");
        equistream::mitsuba_host::require_rigid(m_next.scalar(), "equirect", "to_world_next");
        // Or every new pose would be a new kernel.
        dr::make_opaque(m_to_world, m_previous, m_next);
    }

    field<AffineTransform4f, ScalarAffineTransform4f> m_previous, m_next;
    bool m_has_previous, m_has_next, m_pole_merges;
    uint32_t m_eye;
    ScalarFloat m_ipd, m_longitude_min, m_longitude_max, m_latitude_min, m_latitude_max;
    ScalarFloat m_merge_from, m_merge_to, m_near_clip, m_far_clip;

    MI_TRAVERSE_CB(Base, m_previous, m_next)
};

EQUISTREAM_EXPORT_PLUGIN(EquirectSensor)
NAMESPACE_END(mitsuba)
