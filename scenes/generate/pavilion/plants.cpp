#include "parts.h"

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

glm::vec3 random_direction(Random& random) {
    const float y = random.between(-1, 1), a = tau * random.uniform(), r = std::sqrt(1 - y * y);
    return {r * std::cos(a), y, r * std::sin(a)};
}

glm::mat4 frame(glm::vec3 at, glm::vec3 up, float turn) {
    const glm::vec3 side =
        glm::normalize(glm::cross(up, glm::abs(up.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0)));
    const glm::mat4 axes(glm::vec4(side, 0), glm::vec4(up, 0), glm::vec4(glm::cross(side, up), 0), glm::vec4(at, 1));
    return axes * turned_y(turn);
}

/// A tree's wood as one shape, and the places where its leaves go.
struct Branches {
    Shape wood;
    std::vector<glm::vec3> tips;
};

struct Limb {
    glm::vec3 from, direction;
    float length, radius;
    int forks_left;
};

void grow(const Limb& limb, Random& random, Branches& tree) {
    constexpr int steps = 6;
    std::vector<glm::vec3> points{limb.from};
    std::vector<float> radii{limb.radius};
    glm::vec3 direction = limb.direction;
    for (int i = 1; i <= steps; ++i) {
        direction = glm::normalize(direction + 0.16f * random_direction(random) + glm::vec3(0, 0.05f, 0));
        points.push_back(points.back() + direction * (limb.length / steps));
        radii.push_back(limb.radius *
                        glm::mix(1.0f, limb.forks_left > 0 ? 0.66f : 0.25f, static_cast<float>(i) / steps));
        if (limb.forks_left == 0 && i >= 2)
            tree.tips.push_back(points.back());
        else if (limb.forks_left == 1 && i >= 5)
            tree.tips.push_back(points.back());
    }
    append(tree.wood, tube(points, radii, limb.forks_left > 1 ? 12 : 6));
    if (limb.forks_left == 0)
        return;
    const int forks = limb.forks_left > 2 ? 5 : 4;
    const float first = tau * random.uniform();
    for (int i = 0; i < forks; ++i) {
        const float a = first + tau * (static_cast<float>(i) + 0.4f * random.uniform()) / static_cast<float>(forks);
        const glm::mat4 axes = frame(glm::vec3(0), direction, a);
        const float spread = i == 0 ? 0.25f : random.between(0.55f, 1.0f);
        const glm::vec3 out = glm::normalize(glm::vec3(axes * glm::vec4(spread, 1, 0, 0)));
        const std::size_t at = i == 0 ? points.size() - 1 : points.size() - 1 - static_cast<std::size_t>(i % 3);
        grow({points[at], out, limb.length * random.between(0.62f, 0.8f), radii[at] * 0.72f, limb.forks_left - 1},
             random, tree);
    }
}

Branches grown_tree(std::uint64_t seed) {
    Random random(seed);
    Branches tree;
    grow({{0, -0.3f, 0}, glm::normalize(glm::vec3(0.05f, 1, 0.02f)), 2.6f, 0.19f, 3}, random, tree);
    return tree;
}

}  // namespace

Shape folded_leaf(float width, float length, float fold) {
    return v_turned(sheet(2, 1, [&](float u, float v) {
        const float across = u - 0.5f;
        return glm::vec3(across * width, v * length,
                         width * fold * (std::abs(across) - 0.25f) - 0.12f * length * v * v);
    }));
}

Shape leaf_cluster(int count, float radius, glm::vec2 card_size, std::uint64_t seed) {
    Random random(seed);
    const Shape leaf = folded_leaf(card_size.x, card_size.y, 0.25f);
    Shape cluster;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 out = random_direction(random);
        const glm::vec3 up = glm::normalize(out + 0.7f * random_direction(random) + glm::vec3(0, 0.25f, 0));
        const float scale = random.between(0.75f, 1.2f);
        append(cluster, leaf,
               frame(out * radius * random.between(0.25f, 0.75f), up, tau * random.uniform()) *
                   glm::scale(glm::mat4(1), glm::vec3(scale)));
    }
    return cluster;
}

glm::mat4 scattered(glm::vec3 at, float scale, Random& random) {
    return frame(at, glm::normalize(glm::vec3(0, 1, 0) + 0.6f * random_direction(random)), tau * random.uniform()) *
           glm::scale(glm::mat4(1), glm::vec3(scale));
}

/// Three trees of one growth, turned and scaled: their wood is one mesh, their leaves two clusters, placed hundreds of
/// times.
void build_trees(Site& site) {
    SceneBuilder& scene = site.scene;
    const Branches tree = grown_tree(5);
    const auto wood = scene.mesh("tree", tree.wood, site.paint.bark);
    const std::array clusters{scene.mesh("leaves a", leaf_cluster(22, 0.55f, {0.3f, 0.34f}, 11), site.paint.twig_leaf),
                              scene.mesh("leaves b", leaf_cluster(19, 0.5f, {0.34f, 0.36f}, 12), site.paint.twig_leaf)};
    struct Place {
        float bearing, radius, scale, turn;
    };
    constexpr Place places[] = {
        {322, 9.6f, 1.15f, 0.4f}, {38, 14.5f, 1.25f, 2.5f}, {214, 12.5f, 1.05f, 4.1f}, {262, 17, 1.3f, 5.2f}};
    Random random(6);
    for (const Place& place : places) {
        const glm::vec3 at = at_bearing(place.bearing, place.radius, 0);
        const glm::mat4 here = moved({at.x, ground_height({at.x, at.z}), at.z}) * turned_y(place.turn) *
                               glm::scale(glm::mat4(1), glm::vec3(place.scale));
        scene.object("tree", {wood}, here);
        for (std::size_t i = 0; i < tree.tips.size(); i += 2)
            scene.object("leaves", {clusters[i / 2 % 2]},
                         here * scattered(tree.tips[i], random.between(0.8f, 1.15f), random));
    }
}

/// Slender trees along the way and on the slopes: sprays on a spindle.
void build_cypresses(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(15);
    const Shape spray = folded_leaf(0.42f, 0.75f, 0.3f);
    Shape tree;
    for (int i = 0; i < 320; ++i) {
        const float t = std::pow((static_cast<float>(i) + 0.5f) / 320, 0.85f), a = 2.39996f * static_cast<float>(i);
        const float radius = 0.62f * std::pow(std::sin(3.14159f * std::pow(0.04f + 0.95f * t, 0.6f)), 0.8f);
        const glm::vec3 out(std::cos(a), 0, std::sin(a));
        append(tree, spray,
               frame(out * radius * random.between(0.6f, 0.8f) + glm::vec3(0, 0.25f + 5.6f * t, 0),
                     glm::normalize(0.35f * out + glm::vec3(0, 1, 0) + 0.15f * random_direction(random)),
                     tau * random.uniform()));
    }
    const auto leaves = scene.mesh("cypress", std::move(tree), site.paint.cypress_leaf);
    constexpr glm::vec2 trunk[] = {{0.12f, -0.4f}, {0.1f, 0.4f}, {0.05f, 4.0f}, {0, 5.6f}};
    const auto wood = scene.mesh("cypress trunk", lathe(trunk, 12), site.paint.bark);
    const auto plant = [&](float bearing, float radius, float scale) {
        const glm::vec3 at = at_bearing(bearing, radius, 0);
        scene.object("cypress", {leaves, wood},
                     moved({at.x, ground_height({at.x, at.z}), at.z}) * turned_y(tau * random.uniform()) *
                         glm::scale(glm::mat4(1), glm::vec3(1, random.between(0.9f, 1.15f), 1) * scale));
    };
    for (const float radius : {8.0f, 10.8f, 13.6f, 16.4f})
        for (const float side : {-1.0f, 1.0f})
            plant(180 + side * glm::degrees(std::atan2(2.0f, radius)), std::hypot(radius, 2.0f), 1);
    for (int i = 0; i < 18; ++i)
        plant(random.between(0, 360), random.between(32, 150), random.between(1.1f, 1.7f));
    for (const float bearing : {5.5f, 7.2f, 11.5f, 13.0f})
        plant(bearing, 140 + 1.3f * bearing, 1.5f);
}

/// Round trees of the middle distance, in groups on the slopes.
void build_groves(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(17);
    Shape crown;
    const Shape cluster = leaf_cluster(20, 1.1f, {1.2f, 1.3f}, 18);
    for (const glm::vec3 at :
         {glm::vec3(0, 4.6f, 0), glm::vec3(1.1f, 3.5f, 0.4f), glm::vec3(-0.9f, 3.6f, 0.8f), glm::vec3(0, 3.4f, -1.1f)})
        append(crown, cluster, scattered(at, random.between(0.9f, 1.15f), random));
    const auto leaves = scene.mesh("grove leaves", std::move(crown), site.paint.twig_leaf);
    constexpr glm::vec2 trunk[] = {{0.28f, -0.5f}, {0.12f, 4.2f}};
    const auto wood = scene.mesh("grove trunk", lathe(trunk, 6), site.paint.bark);
    for (int grove = 0; grove < 16; ++grove) {
        const float bearing = 22.5f * static_cast<float>(grove) + random.between(-9, 9),
                    distance = random.between(42, 190);
        const glm::vec3 middle = at_bearing(bearing, distance, 0);
        for (int i = 0; i < 5; ++i) {
            const glm::vec2 at(middle.x + random.between(-11, 11), middle.z + random.between(-11, 11));
            scene.object("grove tree", {leaves, wood},
                         moved({at.x, ground_height(at), at.y}) * turned_y(tau * random.uniform()) *
                             glm::scale(glm::mat4(1), glm::vec3(random.between(0.9f, 1.5f))));
        }
    }
}

}  // namespace equistream::generate::pavilion
