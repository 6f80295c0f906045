/**!

.. _integrator-equirect_aov:

Geometry planes beside any render (:monosp:`equirect_aov`)
----------------------------------------------------------

.. pluginparameters::

 * - aovs
   - |string|
   - Which groups of planes, between commas: ``depth``, ``motion``, ``normal``, ``albedo``, ``ids``, ``specular``,
     ``virtual``, or ``all`` or ``none``. Required.

 * - (Nested plugin)
   - :paramtype:`integrator`
   - Renders the colour: one sampling integrator such as :monosp:`path`, :monosp:`volpath`, :monosp:`direct`,
     :monosp:`prb` or :monosp:`aov`, whose own channels stand before ours. Options for colour (``timeout``,
     ``samples_per_pass``, ``block_size``) go to it and are refused here.

 * - hide_emitters
   - |bool|
   - Ignores directly visible area lights. Set it on the nested integrator too. (Default: false)

 * - to_world_previous, to_world_next
   - |transform|
   - Pose of the sensor at the frame before and the frame after, for sensors that have no such parameters of their own
     (:monosp:`perspective`, :monosp:`thinlens`). (Default: the sensor's pose, i.e. it does not move)
   - |exposed|

 * - object_id, material_id, instance_id
   - |int| array
   - Exposed, not given in a scene file: one number for each of ``scene.shapes()``, in its order, or a single 0; 0
     stands for the default. Ids are at most 16,777,215. Defaults count from 1: shapes (an instance is one), the scene's
     distinct BSDFs, shapes. Mitsuba joins meshes of one BSDF when it loads a scene, and orders them anew in each
     process: ``mi.load_file(FILE, optimize=False)`` keeps meshes and their order. Its command line has no such option.
   - |exposed|

 * - first_face, face_entry
   - |int| array
   - Exposed: ids for each triangle, for merged meshes. ``first_face`` says for each of ``scene.shapes()`` where its
     triangles begin in ``face_entry``, counted from 1; 0: it has none there. ``face_entry`` says for each triangle
     which entry of ``object_id``, ``material_id`` and ``instance_id`` it has. Entries are at most 16,777,215. Make
     these as long as needed. (Default: a single 0)
   - |exposed|

 * - moved_previous, moved_next
   - |float| array
   - Exposed: twelve numbers for each of ``scene.shapes()``, the rows of the 3x4 matrix that takes a world point of this
     frame to where it is in the frame before or after. (Default: a single 0, nothing moves)
   - |exposed|

This integrator renders colour with the nested one, exactly as that would by itself, and then traces one more ray
through the centre of each pixel. What it sees goes into these channels, in single precision and unfiltered whatever the
film's reconstruction filter is:

.. code-block:: text

    albedo    albedo.R .G .B    diffuse reflectance; of metals and glass the colour of what they reflect or let through
    depth     depth.Z           distance from the sensor's place, never from its near plane; +inf where there is nothing
    motion    backward.u .v     pixels from here to where the same point was in the frame before: shortest way round the
              forward.u .v      seam, never NaN; where there is nothing, by the camera's turning only
    normal    normal.X .Y .Z    shading normal, world space, unit, facing the camera
    ids       object_id, material_id, instance_id    whole numbers from 1; 0 where there is nothing
    specular  specular          1 where over 3/4 of what the surface sends on leaves in a delta lobe or one as sharp
                                as GGX with alpha 0.05, else 0
    virtual   virtual_depth.Z   where specular is 1: how far along the ray what is seen in the mirror or through the
              virtual_backward.u .v    glass appears to lie (+inf for the sky in a plane mirror), and its motion;
              virtual_forward.u .v     elsewhere as depth and motion

Names, units and formulas are those of equistream's contract. The surface is the first *visible* one: null surfaces and
what masks cut out (opacity below 1/2) are passed through, glass is not. In omnidirectional stereo distances are from
the column's own eye. Sensors: :monosp:`equirect`; :monosp:`perspective` and :monosp:`thinlens` (through the middle of
the lens), with motion in that view's pixels. Films: :monosp:`hdrfilm` with ``component_format`` float32 (its default,
float16, rounds distances and ids in files, which is warned of), :monosp:`specfilm`.

.. tabs::
    .. code-tab:: xml

        <integrator type="equirect_aov">
            <string name="aovs" value="depth,motion,normal"/>
            <integrator type="path">
                <integer name="max_depth" value="8"/>
            </integrator>
        </integrator>

    .. code-tab:: python

        'type': 'equirect_aov',
        'aovs': 'depth,motion,normal',
        'nested': {'type': 'path', 'max_depth': 8}

        params = mi.traverse(scene)
        params['sensor.to_world_previous'] = params['sensor.to_world']
        params['sensor.to_world'] = mi.ScalarTransform4f().translate([0, 1.6, -0.1])
        params.update()
        image = np.array(mi.render(scene))
        names = scene.integrator().aov_names()
        planes = dict(zip(names, np.moveaxis(image[..., -len(names):], -1, 0)))

Limits:

- It must be the outermost integrator.
- Of colour alone there are gradients: ``render_forward`` and ``render_backward`` are the nested integrator's, and
  those of geometry planes are 0.
- The film's raw storage is left with weight 1 in every pixel.
- Whether a glossy surface is sharp is judged by 16 samples of its lobes: alphas from 0.043 to 0.057 may go either way.
- Mirrors below a shape group are taken to be flat, and all mirrors to stand still from frame to frame.
- A surface inside a medium is seen as if the medium were not there.
 */

#include "film_channels.h"
#include "pixel_geometry.h"
#include "registration.h"
#include "rigid_pose.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>

#include <mitsuba/core/properties.h>
#include <mitsuba/render/integrator.h>

#include <drjit/util.h>

NAMESPACE_BEGIN(mitsuba)

template <typename Float, typename Spectrum>
class EquirectAovIntegrator final : public SamplingIntegrator<Float, Spectrum> {
public:
    MI_IMPORT_BASE(SamplingIntegrator, m_hide_emitters, m_stop)
    MI_IMPORT_TYPES(Scene, Sensor, Film, Medium, Sampler)
    using View = equistream::mitsuba_host::SensorView<Float, Spectrum>;
    using Facts = equistream::mitsuba_host::ShapeFacts<Float, Spectrum>;

    EquirectAovIntegrator(const Properties& props) : Base(props) {
        for (const char* name : {"timeout", "samples_per_pass", "block_size"})
            if (props.has_property(name))
                refuse("equirect_aov: %s: expected in the nested integrator, found in equirect_aov", name);
        choose_planes(std::string(props.get<std::string_view>("aovs")));
        for (auto& prop : props.objects()) {
            Base* integrator = prop.try_get<Base>();
            if (!integrator)
                refuse("equirect_aov: %s: expected a sampling integrator such as \"path\", found %s", prop.name(),
                       prop.get<ref<Object>>()->class_name());
            if (m_nested)
                refuse("equirect_aov: %s: expected one nested integrator, found two", prop.name());
            m_nested = integrator;
        }
        if (!m_nested)
            refuse("equirect_aov: expected a nested integrator such as \"path\", found none");
        if (props.has_property("to_world_previous"))
            m_previous = props.get<ScalarAffineTransform4f>("to_world_previous");
        if (props.has_property("to_world_next"))
            m_next = props.get<ScalarAffineTransform4f>("to_world_next");
        using Ids = DynamicBuffer<UInt32>;
        using Matrices = DynamicBuffer<Float>;
        m_tables = {dr::zeros<Ids>(1), dr::zeros<Ids>(1),      dr::zeros<Ids>(1),     dr::zeros<Ids>(1),
                    dr::zeros<Ids>(1), dr::zeros<Matrices>(1), dr::zeros<Matrices>(1)};
        m_has_previous = props.has_property("to_world_previous");
        m_has_next = props.has_property("to_world_next");
        take_up();
    }

    void traverse(TraversalCallback* cb) override {
        Base::traverse(cb);
        cb->put("nested", m_nested, ParamFlags::NonDifferentiable);
        cb->put("to_world_previous", m_previous, ParamFlags::NonDifferentiable);
        cb->put("to_world_next", m_next, ParamFlags::NonDifferentiable);
        cb->put("object_id", m_tables.object_id, ParamFlags::NonDifferentiable);
        cb->put("material_id", m_tables.material_id, ParamFlags::NonDifferentiable);
        cb->put("instance_id", m_tables.instance_id, ParamFlags::NonDifferentiable);
        cb->put("first_face", m_tables.first_face, ParamFlags::NonDifferentiable);
        cb->put("face_entry", m_tables.face_entry, ParamFlags::NonDifferentiable);
        cb->put("moved_previous", m_tables.moved_previous, ParamFlags::NonDifferentiable);
        cb->put("moved_next", m_tables.moved_next, ParamFlags::NonDifferentiable);
    }

    void parameters_changed(const std::vector<std::string>& keys) override {
        Base::parameters_changed(keys);
        if (string::contains(keys, "to_world_previous")) {
            m_previous = m_previous.value().update();
            m_has_previous = true;
        }
        if (string::contains(keys, "to_world_next")) {
            m_next = m_next.value().update();
            m_has_next = true;
        }
        take_up();
    }

    std::vector<std::string> aov_names() const override {
        std::vector<std::string> names = m_nested->aov_names();
        names.insert(names.end(), m_channels.begin(), m_channels.end());
        return names;
    }

    void cancel() override {
        Base::cancel();
        m_nested->cancel();
    }

    std::pair<Spectrum, Mask> sample(const Scene*, Sampler*, const RayDifferential3f&, const Medium*, Float*,
                                     Mask) const override {
        refuse("equirect_aov: expected to be the outermost integrator, found it nested in another one");
    }

    TensorXf render(Scene* scene, Sensor* sensor, UInt32 seed, uint32_t spp, bool develop, bool evaluate) override {
        m_stop = false;
        View view(sensor);
        if (!view.sphere) {
            if (m_has_previous)
                view.to_world_previous = m_previous.value();
            if (m_has_next)
                view.to_world_next = m_next.value();
        } else if ((m_has_previous || m_has_next) && !m_warned_of_poses) {
            m_warned_of_poses = true;
            Log(Warn, "equirect_aov: to_world_previous and to_world_next are ignored with the sensor \"equirect\": "
                      "set them on the sensor");
        }
        const Facts facts(scene, m_hide_emitters);
        check_tables(facts.count());
        Film* film = sensor->film();
        equistream::mitsuba_host::FilmChannels<Float, Spectrum> channels(film);
        if (!m_channels.empty() && channels.writes_halves() && !m_warned) {
            m_warned = true;
            Log(Warn, "equirect_aov: the film's component_format is float16: files will hold rounded distances, motion "
                      "and ids. Set it to float32.");
        }
        check_names();
        // Integrators written in Python refuse to leave the film undeveloped.
        const bool in_python = m_nested->class_name() == Base::ClassName;
        m_nested->render(scene, sensor, seed, spp, in_python, evaluate);
        const equistream::mitsuba_host::PixelGeometry<Float, Spectrum> geometry(scene, sensor, view, facts, m_tables,
                                                                                m_entries, m_appearance);
        channels.add(aov_names(), (uint32_t)m_channels.size(),
                     [&](const UInt32& x, const UInt32& y, Float* out) { geometry.put(m_planes, x, y, out); });
        return developed(film, develop, evaluate);
    }

    TensorXf render_forward(Scene* scene, void* params, Sensor* sensor, UInt32 seed, uint32_t spp) override {
        const TensorXf colour = m_nested->render_forward(scene, params, sensor, seed, spp);
        return with_channels(colour, colour.shape(2) + m_channels.size());
    }

    void render_backward(Scene* scene, void* params, const TensorXf& grad_in, Sensor* sensor, UInt32 seed,
                         uint32_t spp) override {
        if (grad_in.ndim() != 3 || grad_in.shape(2) <= m_channels.size())
            refuse(
                "equirect_aov: expected the gradient of an image with this integrator's channels, found another shape");
        m_nested->render_backward(scene, params, with_channels(grad_in, grad_in.shape(2) - m_channels.size()), sensor,
                                  seed, spp);
    }

    std::string to_string() const override {
        std::ostringstream oss;
        oss << "EquirectAovIntegrator[" << std::endl << "  aovs = [";
        for (size_t i = 0; i < m_planes.size(); ++i)
            oss << (i ? ", " : "") << m_planes[i];
        oss << "]," << std::endl << "  nested = " << string::indent(m_nested) << std::endl << "]";
        return oss.str();
    }

    MI_DECLARE_CLASS(EquirectAovIntegrator)

private:
    template <typename... Values>
    [[noreturn]] static void refuse(const char* format, const Values&... values) {
        equistream::mitsuba_host::refuse(format, values...);
    }

    /// Called whenever a pose or a table may have changed.
    void take_up() {
        equistream::mitsuba_host::require_rigid(m_previous.scalar(), "equirect_aov", "to_world_previous");
        equistream::mitsuba_host::require_rigid(m_next.scalar(), "equirect_aov", "to_world_next");
        m_checked_for = (uint32_t)-1;
        check_ids("object_id", m_tables.object_id);
        check_ids("material_id", m_tables.material_id);
        check_ids("instance_id", m_tables.instance_id);
        // Or every new table would be a new kernel.
        dr::make_opaque(m_previous, m_next, m_tables);
    }

    void choose_planes(const std::string& groups) {
        std::vector<std::string> planes;
        try {
            planes = equistream::parse_aov_groups(groups, true);
        } catch (const std::exception& error) {
            refuse("equirect_aov: %s", error.what());
        }
        for (const std::string& plane : planes) {
            if (plane == "colour")
                continue;
            const equistream::AovInfo aov = *equistream::find_aov(plane);
            m_planes.push_back(plane);
            m_channels.insert(m_channels.end(), aov.channels.begin(), aov.channels.end());
        }
    }

    static constexpr uint32_t largest_id = (1u << 24) - 1;

    static void check_ids(const char* name, const DynamicBuffer<UInt32>& ids) {
        const uint32_t found = dr::width(ids) != 0 ? dr::slice<uint32_t>(dr::max(ids)) : 0;
        if (found > largest_id)
            refuse("equirect_aov: %s: expected ids up to %u (a film stores single precision), found %u", name,
                   largest_id, found);
    }

    /// Mitsuba's film finds this out too, but after the rendering and without the name.
    void check_names() const {
        std::vector<std::string> names = aov_names();
        std::sort(names.begin(), names.end());
        const auto twice = std::adjacent_find(names.begin(), names.end());
        if (twice != names.end())
            refuse("equirect_aov: expected channels of different names, found \"%s\" twice", *twice);
    }

    template <typename Table>
    static bool is_default(const Table& table) {
        return dr::width(table) == 0 || (dr::width(table) == 1 && dr::slice(table) == 0);
    }

    template <typename Table>
    static void check_count(const char* name, const Table& table, uint32_t shapes, uint32_t each) {
        const size_t found = dr::width(table);
        if (!is_default(table) && found != (size_t)shapes * each)
            refuse(
                "equirect_aov: %s: expected %u numbers (%u for each of the scene's %u shapes) or a single 0, found %u",
                name, shapes * each, each, shapes, found);
    }

    void check_entries(const char* name, const DynamicBuffer<UInt32>& ids, uint32_t shapes) const {
        if (m_entries == shapes)
            return check_count(name, ids, shapes, 1);
        if (!is_default(ids) && dr::width(ids) < m_entries)
            refuse("equirect_aov: %s: expected %u numbers, for all entries of face_entry, or a single 0, found %u",
                   name, m_entries, (uint32_t)dr::width(ids));
    }

    /// Returns how many entries the tables of ids have: one a shape, and those that triangles have instead.
    uint32_t check_faces(uint32_t shapes) const {
        check_count("first_face", m_tables.first_face, shapes, 1);
        const uint32_t last =
            dr::width(m_tables.first_face) != 0 ? dr::slice<uint32_t>(dr::max(m_tables.first_face)) : 0;
        if (last == 0)
            return shapes;
        if (last > dr::width(m_tables.face_entry))
            refuse("equirect_aov: first_face: expected places on face_entry's %u numbers, counted from 1, found %u",
                   (uint32_t)dr::width(m_tables.face_entry), last);
        const uint32_t entry = dr::slice<uint32_t>(dr::max(m_tables.face_entry));
        if (entry > largest_id)
            refuse("equirect_aov: face_entry: expected entries up to %u, found %u", largest_id, entry);
        return std::max(shapes, entry + 1);
    }

    void check_tables(uint32_t shapes) {
        if (shapes == m_checked_for)
            return;
        m_entries = check_faces(shapes);
        check_entries("object_id", m_tables.object_id, shapes);
        check_entries("material_id", m_tables.material_id, shapes);
        check_entries("instance_id", m_tables.instance_id, shapes);
        check_count("moved_previous", m_tables.moved_previous, shapes, 12);
        check_count("moved_next", m_tables.moved_next, shapes, 12);
        m_checked_for = shapes;
    }

    static TensorXf developed(Film* film, bool develop, bool evaluate) {
        TensorXf result;
        if (develop)
            result = film->develop();
        if constexpr (dr::is_jit_v<Float>) {
            if (develop)
                dr::schedule(result);
            else
                film->schedule_storage();
            if (evaluate) {
                dr::eval();
                dr::sync_thread();
            }
        }
        return result;
    }

    /// An image's first channels, or all of them with zeros behind.
    static TensorXf with_channels(const TensorXf& image, size_t count) {
        const uint32_t from = (uint32_t)image.shape(2), to = (uint32_t)count;
        const size_t pixels = image.shape(0) * image.shape(1);
        const size_t shape[3] = {image.shape(0), image.shape(1), count};
        using Array = typename TensorXf::Array;
        if constexpr (dr::is_jit_v<Float>) {
            const UInt32 i = dr::arange<UInt32>(pixels * count), pixel = i / to, channel = dr::fnmadd(pixel, to, i);
            const Array values = dr::gather<Array>(image.array(), pixel * from + channel, channel < from);
            return TensorXf(values, 3, shape);
        } else {
            Array values = dr::zeros<Array>(pixels * count);
            for (size_t pixel = 0; pixel < pixels; ++pixel)
                for (size_t c = 0; c < std::min(from, to); ++c)
                    values.data()[pixel * to + c] = image.data()[pixel * from + c];
            return TensorXf(values, 3, shape);
        }
    }

    ref<Base> m_nested;
    std::vector<std::string> m_planes, m_channels;
    equistream::mitsuba_host::Appearance<Float, Spectrum> m_appearance;
    equistream::mitsuba_host::ShapeTables<Float> m_tables;
    field<AffineTransform4f, ScalarAffineTransform4f> m_previous{ScalarAffineTransform4f()},
        m_next{ScalarAffineTransform4f()};
    /// Number of shapes that the tables were found right for.
    uint32_t m_checked_for = (uint32_t)-1, m_entries = 0;
    bool m_has_previous = false, m_has_next = false, m_warned = false, m_warned_of_poses = false;

    MI_TRAVERSE_CB(Base, m_nested, m_tables, m_previous, m_next)
};

EQUISTREAM_EXPORT_PLUGIN(EquirectAovIntegrator)
NAMESPACE_END(mitsuba)
