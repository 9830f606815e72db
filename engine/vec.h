// Vectors of the whole project: GLM in double precision. Positions are metres in the scene's own
// frame (Scene::frame says where its origin lies); colours are linear Rec.709.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace atrium {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using glm::cross;
using glm::dot;
using glm::length;
using glm::normalize;

}  // namespace atrium
