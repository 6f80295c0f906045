#pragma once
/// Rays of anybody's through a scene of Mitsuba's: how far they go, and what comes along them. In scalar variants by
/// many threads.
#include "embedded_scene.h"
#include "variant_arrays.h"

#include <host-adapters/mitsuba3/plugins/appearance.h>
#include <host-adapters/mitsuba3/plugins/first_surface.h>

#include <mitsuba/core/properties.h>
#include <mitsuba/render/integrator.h>
#include <mitsuba/render/sampler.h>
#include <mitsuba/render/sensor.h>
#include <nanothread/nanothread.h>

#include <algorithm>
#include <optional>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
class RayTracer {
public:
    MI_IMPORT_TYPES(Scene, Sensor, Sampler, Medium, SamplingIntegrator)
    using Arrays = VariantArrays<Float>;
    using Integrator = SamplingIntegrator;

    /// `scene` is borrowed. Objects of no_surface_id are those that rays do not meet. Without `ids` shapes and
    /// materials count from 1, as the integrator has them.
    RayTracer(const Scene* scene, bool hides_emitters, const ShapeIds& ids)
        : scene_(scene), facts_(scene, hides_emitters), is_numbered_(!ids.object.empty()) {
        std::size_t entries = facts_.count();
        for (const std::uint32_t entry : ids.face_entry)
            entries = std::max(entries, std::size_t{entry} + 1);
        objects_.take(ids.object, entries);
        materials_.take(ids.material, entries);
        first_faces_.take(ids.first_face, facts_.count());
        face_entries_.take(ids.face_entry, std::max<std::size_t>(ids.face_entry.size(), 1));
    }

    std::vector<float> distances(const RayBatch& rays) const {
        std::vector<float> result(rays.size());
        for_all(rays, nullptr, 0, [&](const Ray3f& ray, const Float& begin, Sampler*, const auto& put) {
            const FirstSurface<Float, Spectrum> first(scene_, RayDifferential3f(ray), facts_, true);
            put(result, 1, 0, Float(dr::select(is_surface(first), first.distance + begin, dr::Infinity<Float>)));
        });
        return result;
    }

    std::vector<float> radiance(const RayBatch& rays, Integrator& integrator, Sensor& sensor,
                                std::uint32_t seed) const {
        std::vector<float> result(4 * rays.size());
        mitsuba::ref<Sampler> sampler = sensor.sampler()->fork();
        for_all(rays, sampler.get(), seed, [&](Ray3f ray, const Float&, Sampler* random, const auto& put) {
            Spectrum weight(1.f);
            if constexpr (mitsuba::is_spectral_v<Spectrum>)
                std::tie(ray.wavelengths, weight) =
                    sensor.sample_wavelengths(dr::zeros<SurfaceInteraction3f>(), random->next_1d());
            const RayDifferential3f differential(ray);
            std::vector<Float> aovs(integrator.aov_names().size());
            const Spectrum arrived =
                weight * integrator.sample(scene_, random, differential, sensor.medium(), aovs.data(), true).first;
            const auto colour = mitsuba::unpolarized_spectrum(arrived);
            Color3f rgb;
            if constexpr (mitsuba::is_spectral_v<Spectrum>)
                rgb = mitsuba::spectrum_to_srgb(colour, ray.wavelengths);
            else if constexpr (mitsuba::is_monochromatic_v<Spectrum>)
                rgb = Color3f(colour.x());
            else
                rgb = colour;
            const FirstSurface<Float, Spectrum> first(scene_, differential, facts_, true);
            Float alpha = dr::select(is_surface(first), Float(1.f), Float(0.f));
            dr::eval(rgb, alpha);  // in one kernel
            for (std::size_t c = 0; c < 3; ++c)
                put(result, 4, c, rgb[c]);
            put(result, 4, 3, alpha);
        });
        return result;
    }

    std::vector<float> guides(const RayBatch& rays) const {
        std::vector<float> result(guide_channels * rays.size());
        const Appearance<Float, Spectrum> appearance;
        for_all(rays, nullptr, 0, [&](const Ray3f& ray, const Float&, Sampler*, const auto& put) {
            GuideRay<Float, Spectrum> guide(scene_, facts_, appearance, RayDifferential3f(ray), true);
            dr::eval(guide.albedo, guide.normal);  // in one kernel
            for (std::size_t c = 0; c < 3; ++c) {
                put(result, guide_channels, c, guide.albedo[c]);
                put(result, guide_channels, 3 + c, guide.normal[c]);
            }
        });
        return result;
    }

    std::vector<std::uint32_t> ids(const RayBatch& rays) const {
        std::vector<float> found(2 * rays.size());
        for_all(rays, nullptr, 0, [&](const Ray3f& ray, const Float&, Sampler*, const auto& put) {
            const FirstSurface<Float, Spectrum> first(scene_, RayDifferential3f(ray), facts_, true);
            const Mask hit = is_surface(first);
            const UInt32 shape = facts_.index(first.si.shape, first.si.instance, hit);
            if (!is_numbered_) {
                put(found, 2, 0, Float(dr::select(hit, shape + 1u, UInt32(0u))));
                put(found, 2, 1, Float(dr::select(hit, facts_.material(first.si.shape, hit), UInt32(0u))));
                return;
            }
            // Of a mesh that holds several, each triangle has an entry of its own.
            const UInt32 place = first_faces_.at(shape, hit);
            const Mask merged = hit && place != 0u;
            const UInt32 entry = dr::select(
                merged, face_entries_.at(dr::select(merged, place - 1u + first.si.prim_index, 0u), merged), shape);
            // Ids are below no_surface_id, 2^24: floats hold them.
            put(found, 2, 0, Float(dr::select(hit, objects_.at(entry, hit), UInt32(0u))));
            put(found, 2, 1, Float(dr::select(hit, materials_.at(entry, hit), UInt32(0u))));
        });
        return {found.begin(), found.end()};
    }

private:
    /// Numbers that are looked up by a variant's integers.
    class Table {
    public:
        void take(const std::vector<std::uint32_t>& values, std::size_t count) {
            values_ = values;
            values_.resize(count);
            if constexpr (Arrays::is_jit)
                loaded_ = dr::load<UInt32>(values_.data(), values_.size());
        }
        UInt32 at(const UInt32& place, const Mask& active) const {
            if constexpr (Arrays::is_jit)
                return dr::gather<UInt32>(loaded_, place, active);
            else
                return active ? values_[place] : 0u;
        }

    private:
        std::vector<std::uint32_t> values_;
        UInt32 loaded_ = 0u;
    };

    /// Whether a ray meets what is a surface to us.
    Mask is_surface(const FirstSurface<Float, Spectrum>& first) const {
        const Mask hit = first.si.is_valid();
        const UInt32 shape = facts_.index(first.si.shape, first.si.instance, hit);
        return hit && objects_.at(shape, hit) != no_surface_id;
    }

    /// Calls work(ray, begin, sampler, put) for all rays at once, or ray by ray; put(result, stride, channel, value)
    /// stores what it found. Rays begin where they are to begin: Mitsuba's have no least distance.
    template <typename Work>
    void for_all(const RayBatch& rays, Sampler* sampler, std::uint32_t seed, const Work& work) const {
        const auto made = [](const auto& value, std::size_t i) {
            if constexpr (Arrays::is_jit)
                return (void)i, dr::load<Float>(value.data(), value.size());
            else
                return value[i];
        };
        const auto trace = [&](std::size_t i, Sampler* random) {
            const Vector3f direction(made(rays.direction[0], i), made(rays.direction[1], i),
                                     made(rays.direction[2], i));
            const Float begin = made(rays.begin, i);
            Ray3f ray(Point3f(made(rays.origin[0], i), made(rays.origin[1], i), made(rays.origin[2], i)), direction);
            ray.o = dr::fmadd(direction, begin, ray.o);
            ray.maxt = made(rays.end, i) - begin;
            work(ray, begin, random,
                 [&](std::vector<float>& result, std::size_t stride, std::size_t channel, const Float& value) {
                     if constexpr (Arrays::is_jit) {
                         const std::vector<float> host = Arrays::to_host(value);
                         for (std::size_t k = 0; k < rays.size(); ++k)
                             result[k * stride + channel] = host[host.size() == 1 ? 0 : k];
                     } else {
                         result[i * stride + channel] = value;
                     }
                 });
        };
        if (rays.size() == 0)
            return;
        if constexpr (Arrays::is_jit) {
            if (sampler)
                sampler->seed(dr::opaque<UInt32>(seed), static_cast<std::uint32_t>(rays.size()));
            trace(0, sampler);
        } else {
            constexpr std::size_t block = 256;
            dr::parallel_for(dr::blocked_range<std::size_t>(0, rays.size(), block),
                             [&](const dr::blocked_range<std::size_t>& part) {
                                 mitsuba::ref<Sampler> own = sampler ? sampler->fork() : nullptr;
                                 if (own)
                                     own->seed(static_cast<std::uint32_t>(seed + part.begin() / block));
                                 for (std::size_t i = part.begin(); i != part.end(); ++i)
                                     trace(i, own.get());
                             });
        }
    }

    const Scene* scene_;
    ShapeFacts<Float, Spectrum> facts_;
    bool is_numbered_;
    Table objects_, materials_;         // by entry: shapes, then those of triangles
    Table first_faces_, face_entries_;  // as ShapeIds has them
};

// Whether rays meet a surface, as alpha: what a frame's colour says of itself. Mitsuba's path integrator calls the sky
// a hit, and its depth integrator the holes of masks. As AOVs what guides a denoiser, where it is asked for.

template <typename Float, typename Spectrum>
class HitIntegrator final : public mitsuba::SamplingIntegrator<Float, Spectrum> {
public:
    using Base = mitsuba::SamplingIntegrator<Float, Spectrum>;
    MI_IMPORT_TYPES(Scene, Sensor, Medium, Sampler)

    HitIntegrator(bool hides_emitters, bool guides)
        : Base(mitsuba::Properties("equistream_hits")), hides_emitters_(hides_emitters), guides_(guides) {}

    std::vector<std::string> aov_names() const override {
        return guides_
                   ? std::vector<std::string>{"albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z"}
                   : std::vector<std::string>();
    }

    TensorXf render(Scene* scene, Sensor* sensor, UInt32 seed, std::uint32_t spp, bool develop,
                    bool evaluate) override {
        facts_.emplace(scene, hides_emitters_);
        return Base::render(scene, sensor, seed, spp, develop, evaluate);
    }

    std::pair<Spectrum, Mask> sample(const Scene* scene, Sampler*, const RayDifferential3f& ray, const Medium*,
                                     Float* aovs, Mask active) const override {
        if (guides_) {
            const GuideRay<Float, Spectrum> guide(scene, *facts_, appearance_, ray, active);
            for (std::size_t c = 0; c < 3; ++c) {
                aovs[c] = guide.albedo[c];
                aovs[3 + c] = guide.normal[c];
            }
            return {Spectrum(0.f), active && guide.hit};
        }
        const FirstSurface<Float, Spectrum> first(scene, ray, *facts_, active);
        return {Spectrum(0.f), active && first.si.is_valid()};
    }

    MI_DECLARE_CLASS(HitIntegrator)

private:
    bool hides_emitters_, guides_;
    Appearance<Float, Spectrum> appearance_;
    std::optional<ShapeFacts<Float, Spectrum>> facts_;
};

}  // namespace equistream::mitsuba_host
