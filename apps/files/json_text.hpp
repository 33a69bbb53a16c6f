#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "axode/lie/twist.hpp"

/// Mechanical quantities as JSON, with all digits of the doubles; infinity, which means no limit, is null.
namespace axode::command {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3<>& a);
/// The six numbers of a symmetric tensor as the array [xx, yy, zz, xy, xz, yz].
Json to_json(const Sym3<>& A);
/// A pose as the four rows of the matrix [[R, r], [0, 1]].
Json to_json(const SE3<>& C);
/// A twist, twist rate, wrench or momentum as an array of six numbers, angular part first.
template <template <class, class> class Kind, class Rep>
  requires is_screw_kind<Kind> Json to_json(const Kind<Rep, double>& x) {
    const auto& [a, b] = x;
    return {a.x, a.y, a.z, b.x, b.y, b.z};
  }

/// The JSON as text, with one key on a line. Arrays of numbers and short objects are on one line.
std::string text(const Json& value);

}  // namespace axode::command
