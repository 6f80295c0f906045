/**!
 */

#include "appearance.h"
#include "first_surface.h"
#include "refusal.h"
#include "registration.h"
#include "sensor_view.h"
#include "shape_facts.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>

#include <mitsuba/core/properties.h>
#include <mitsuba/render/imageblock.h>
#include <mitsuba/render/integrator.h>

#include <nanothread/nanothread.h>

#include <algorithm>
#include <memory>

NAMESPACE_BEGIN(mitsuba)

template <typename Float, typename Spectrum>
class EquirectAovIntegrator final : public SamplingIntegrator<Float, Spectrum> {
public:
    MI_IMPORT_BASE(SamplingIntegrator, m_hide_emitters, m_stop)
    MI_IMPORT_TYPES(Scene, Sensor, Film, ImageBlock, Medium, Sampler, BSDF, BSDFPtr, Shape, ShapePtr)
    using SensorView = equistream::mitsuba_host::SensorView<Float, Spectrum>;
    using ShapeFacts = equistream::mitsuba_host::ShapeFacts<Float, Spectrum>;
    using FirstSurface = equistream::mitsuba_host::FirstSurface<Float, Spectrum>;

    EquirectAovIntegrator(const Properties& props) : Base(props) {
        for (const std::string& plane : equistream::parse_aov_groups(props.get<std::string_view>("aovs"))) {
            if (plane == "colour")
                continue;
            planes_.push_back(plane);
            const equistream::AovInfo aov = *equistream::find_aov(plane);
            channels_.insert(channels_.end(), aov.channels.begin(), aov.channels.end());
        }
        for (auto& prop : props.objects()) {
            Base* integrator = prop.try_get<Base>();
            if (!integrator)
                equistream::mitsuba_host::refuse(
                    "equirect_aov: expected one nested sampling integrator such as \"path\", found \"%s\"",
                    prop.name());
            if (m_nested)
                equistream::mitsuba_host::refuse("equirect_aov: expected one nested integrator, found two");
            m_nested = integrator;
        }
        if (!m_nested)
            equistream::mitsuba_host::refuse("equirect_aov: expected a nested integrator such as \"path\", found none");
    }

    void traverse(TraversalCallback* cb) override {
        Base::traverse(cb);
        cb->put("integrator", m_nested, ParamFlags::NonDifferentiable);
        cb->put("object_id", m_object_id, ParamFlags::NonDifferentiable);
        cb->put("material_id", m_material_id, ParamFlags::NonDifferentiable);
        cb->put("instance_id", m_instance_id, ParamFlags::NonDifferentiable);
        cb->put("moved_previous", m_moved_previous, ParamFlags::NonDifferentiable);
        cb->put("moved_next", m_moved_next, ParamFlags::NonDifferentiable);
    }

    void parameters_changed(const std::vector<std::string>& keys) override {
        Base::parameters_changed(keys);
        dr::make_opaque(m_object_id, m_material_id, m_instance_id, m_moved_previous, m_moved_next);
    }

    std::vector<std::string> aov_names() const override {
        std::vector<std::string> names = m_nested->aov_names();
        names.insert(names.end(), channels_.begin(), channels_.end());
        return names;
    }

    void cancel() override {
        Base::cancel();
        m_nested->cancel();
    }

    std::pair<Spectrum, Mask> sample(const Scene*, Sampler*, const RayDifferential3f&, const Medium*, Float*,
                                     Mask) const override {
        equistream::mitsuba_host::refuse(
            "equirect_aov: expected to be the outermost integrator, found it nested in another one");
    }

    TensorXf render(Scene* scene, Sensor* sensor, UInt32 seed, uint32_t spp, bool develop, bool evaluate) override {
        m_stop = false;
        const SensorView view(sensor);
        const ShapeFacts facts(scene, m_hide_emitters);
        check_tables(facts.count());
        Film* film = sensor->film();
        m_nested->render(scene, sensor, seed, spp, false, evaluate);
        const TensorXf colour = film->develop(true);
        film->prepare(aov_names());
        film->put_block(repacked(scene, sensor, view, facts, colour).get());
        TensorXf result;
        if (develop) {
            result = film->develop();
            if constexpr (dr::is_jit_v<Float>)
                dr::schedule(result);
        } else {
            film->schedule_storage();
        }
        if constexpr (dr::is_jit_v<Float>) {
            if (evaluate) {
                dr::eval();
                dr::sync_thread();
            }
        }
        return result;
    }

    std::string to_string() const override {
        std::ostringstream oss;
        oss << "EquirectAovIntegrator[" << std::endl << "  aovs = [";
        for (size_t i = 0; i < planes_.size(); ++i)
            oss << (i ? ", " : "") << planes_[i];
        oss << "]," << std::endl << "  nested = " << string::indent(m_nested) << std::endl << "]";
        return oss.str();
    }

    MI_DECLARE_CLASS(EquirectAovIntegrator)

private:
    void check_tables(uint32_t shapes) const {
        const auto check = [shapes](const char* name, size_t found, size_t each) {
            if (found != 0 && found != shapes * each)
                equistream::mitsuba_host::refuse(
                    "equirect_aov: %s: expected %u entries (%u for each of the scene's %u shapes) or none, found %u",
                    name, shapes * each, each, shapes, found);
        };
        check("object_id", dr::width(m_object_id), 1);
        check("material_id", dr::width(m_material_id), 1);
        check("instance_id", dr::width(m_instance_id), 1);
        check("moved_previous", dr::width(m_moved_previous), 12);
        check("moved_next", dr::width(m_moved_next), 12);
    }

    /// The film's storage with our channels besides. Each pixel is divided by its weight, so that what is developed,
    /// written or developed again are the values themselves: x * weight / weight is not always x.
    ref<ImageBlock> repacked(const Scene* scene, const Sensor* sensor, const SensorView& view, const ShapeFacts& facts,
                             const TensorXf& colour) const {
        Film* film = const_cast<Sensor*>(sensor)->film();
        const uint32_t before = (uint32_t)colour.shape(2);
        const uint32_t ours = (uint32_t)channels_.size();
        const uint32_t after = before + ours;
        const bool weight_is_last = has_flag(film->flags(), FilmFlags::Special);
        const uint32_t weight_at = weight_is_last ? before - 1 : has_flag(film->flags(), FilmFlags::Alpha) ? 4 : 3;
        const uint32_t first = weight_is_last ? before - 1 : before;
        const ScalarVector2u size = view.crop_size;
        ref<ImageBlock> block = film->create_block();
        block->set_offset(film->crop_offset());
        const auto target_of = [=](uint32_t c) { return c < first ? c : c + ours; };
        const size_t shape[3] = {size.y(), size.x(), after};
        if constexpr (dr::is_jit_v<Float>) {
            const UInt32 i = dr::arange<UInt32>(size.x() * size.y());
            UInt32 y = i / size.x(), x = dr::fnmadd(y, size.x(), i);
            std::vector<Float> values(ours);
            geometry(scene, sensor, view, facts, x, y, values.data());
            Float out = dr::zeros<Float>((size_t)size.x() * size.y() * after);
            const Float weight = dr::gather<Float>(colour.array(), i * before + weight_at);
            const Float scale = dr::select(weight != 0.f, dr::rcp(weight), 1.f);
            for (uint32_t c = 0; c < before; ++c) {
                const Float value =
                    c == weight_at ? Float(1.f) : dr::gather<Float>(colour.array(), i * before + c) * scale;
                dr::scatter(out, value, i * after + target_of(c));
            }
            for (uint32_t c = 0; c < ours; ++c)
                dr::scatter(out, values[c], i * after + (first + c));
            block->tensor() = TensorXf(out, 3, shape);
        } else {
            const ScalarFloat* from = colour.data();
            ScalarFloat* to = block->tensor().data();
            dr::parallel_for(dr::blocked_range<uint32_t>(0, size.y(), 4), [&](const dr::blocked_range<uint32_t>& rows) {
                for (uint32_t y = rows.begin(); y != rows.end(); ++y)
                    for (uint32_t x = 0; x < size.x(); ++x) {
                        const size_t i = (size_t)y * size.x() + x;
                        const ScalarFloat* pixel = from + i * before;
                        ScalarFloat* out = to + i * after;
                        const ScalarFloat weight = pixel[weight_at];
                        const ScalarFloat scale = weight != 0 ? 1 / weight : 1;
                        for (uint32_t c = 0; c < before; ++c)
                            out[target_of(c)] = c == weight_at ? 1 : pixel[c] * scale;
                        geometry(scene, sensor, view, facts, x, y, out + first);
                    }
            });
        }
        return block;
    }

    /// Our channels of pixel (x, y) of the crop window, in the order of channels_.
    void geometry(const Scene* scene, const Sensor* sensor, const SensorView& view, const ShapeFacts& facts, UInt32 x,
                  UInt32 y, Float* out) const {
        const Point2f centre(Float(x) + 0.5f, Float(y) + 0.5f);
        const Point2f position = centre / ScalarVector2f(view.crop_size);
        const Float time = sensor->shutter_open() + 0.5f * sensor->shutter_open_time();
        auto [ray, weight] = sensor->sample_ray_differential(time, 0.5f, position, Point2f(0.5f));
        const FirstSurface surface(scene, ray, facts, true);
        const SurfaceInteraction3f& si = surface.si;
        const Mask hit = si.is_valid();
        const equistream::PixelCoordinates<Float> here{centre.x() + (ScalarFloat)view.crop_offset.x(),
                                                       centre.y() + (ScalarFloat)view.crop_offset.y()};
        const BSDFPtr bsdf = si.bsdf();
        const UInt32 index = facts.index(si.shape, si.instance, hit);
        for (const std::string& plane : planes_) {
            if (plane == "depth") {
                *out++ = surface.distance + near_distance(view, ray);
            } else if (plane == "albedo") {
                const Color3f rgb = m_appearance.albedo(bsdf, si, facts.any_without_diffuse(), hit);
                for (size_t c = 0; c < 3; ++c)
                    *out++ = rgb[c];
            } else if (plane == "normal") {
                Normal3f n = bsdf->sh_frame(si, hit).n;
                n = dr::select(dr::dot(n, ray.d) > 0.f, -n, n);
                for (size_t c = 0; c < 3; ++c)
                    *out++ = dr::select(hit, n[c], 0.f);
            } else if (plane == "backward") {
                out = put_motion(view, here, ray, si, index, m_moved_previous, view.to_world_previous, out);
            } else if (plane == "forward") {
                out = put_motion(view, here, ray, si, index, m_moved_next, view.to_world_next, out);
            } else if (plane == "object_id") {
                *out++ = dr::select(hit, Float(id(m_object_id, index, index + 1u, hit)), 0.f);
            } else if (plane == "material_id") {
                *out++ = dr::select(hit, Float(id(m_material_id, index, facts.material(si.shape, hit), hit)), 0.f);
            } else if (plane == "instance_id") {
                *out++ = dr::select(hit, Float(id(m_instance_id, index, index + 1u, hit)), 0.f);
            } else if (plane == "specular") {
                Float flag = 0.f;
                if (facts.any_sharp())
                    flag = dr::select(m_appearance.is_specular(bsdf, si, hit), Float(1.f), Float(0.f));
                *out++ = flag;
            }
        }
    }

    static UInt32 id(const DynamicBuffer<UInt32>& table, const UInt32& index, const UInt32& otherwise,
                     const Mask& hit) {
        if (dr::width(table) == 0)
            return otherwise;
        const UInt32 given = dr::gather<UInt32>(table, index, hit);
        return dr::select(given != 0u, given, otherwise);
    }

    /// How far from the sensor's own place its rays begin.
    Float near_distance(const SensorView& view, const RayDifferential3f& ray) const {
        return view.ods_side != 0 ? Float(0.f) : Float(dr::norm(ray.o - view.centre(view.to_world)));
    }

    Float* put_motion(const SensorView& view, const equistream::PixelCoordinates<Float>& here,
                      const RayDifferential3f& ray, const SurfaceInteraction3f& si, const UInt32& index,
                      const DynamicBuffer<Float>& moved, const AffineTransform4f& there, Float* out) const {
        const Mask hit = si.is_valid();
        Point3f p = si.p;
        if (dr::width(moved) != 0) {
            std::array<Float, 12> m;
            for (uint32_t k = 0; k < 12; ++k)
                m[k] = dr::gather<Float>(moved, index * 12u + k, hit);
            p = Point3f(m[0] * si.p.x() + m[1] * si.p.y() + m[2] * si.p.z() + m[3],
                        m[4] * si.p.x() + m[5] * si.p.y() + m[6] * si.p.z() + m[7],
                        m[8] * si.p.x() + m[9] * si.p.y() + m[10] * si.p.z() + m[11]);
        }
        const Vector2f motion =
            dr::select(hit, view.motion_of_point(here, p, there), view.motion_of_direction(here, ray.d, there));
        *out++ = motion.x();
        *out++ = motion.y();
        return out;
    }

    ref<Base> m_nested;
    std::vector<std::string> planes_, channels_;
    equistream::mitsuba_host::Appearance<Float, Spectrum> m_appearance;
    DynamicBuffer<UInt32> m_object_id, m_material_id, m_instance_id;
    DynamicBuffer<Float> m_moved_previous, m_moved_next;

    MI_TRAVERSE_CB(Base, m_nested, m_object_id, m_material_id, m_instance_id, m_moved_previous, m_moved_next)
};

EQUISTREAM_EXPORT_PLUGIN(EquirectAovIntegrator)
NAMESPACE_END(mitsuba)
