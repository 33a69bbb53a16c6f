#pragma once
#include <nanobind/nanobind.h>

#include "axode/io.hpp"

/// Descriptions of mechanisms as Python's objects.
namespace axode::python {

namespace nb = nanobind;

/// Every field of a description as nested tuples, for pickle; and back.
nb::tuple packed(const Description& description);
Description unpacked(nb::handle tuple);

/// The argument `strict`.
inline Strictness strictness(bool strict) { return strict ? Strictness::strict : Strictness::lenient; }

/// A mechanism in the words of the drawing format (docs/drawing-format.md), as a dict: what a drawing reads
/// as. Throws ModelError with every fault, and nb::type_error for what a drawing cannot hold. It may come from a file of
/// another format, with warnings.
Model from_dict(const nb::dict& drawing, Base base, Strictness strictness, const std::string& file = "",
                const std::vector<Fault>& warnings = {});
nb::dict to_dict(const Model& model);
/// A joint in the words of a drawing, with axis and point in the frame on which it is; a fixed one if it is None.
JointDescription joint_of(nb::handle joint);

}  // namespace axode::python
