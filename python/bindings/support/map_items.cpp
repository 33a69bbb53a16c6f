#include "python/bindings/support/map_items.hpp"

#include <cmath>

namespace axode::python {

void check_structure(const char* argument, const char* expected,
                     const Eigen::Ref<const Eigen::MatrixXd>& given,
                     const Eigen::Ref<const Eigen::MatrixXd>& made) {
  Eigen::Index i = 0, j = 0;
  const double off = (given - made).cwiseAbs().maxCoeff(&i, &j);
  if (off <= 1e-6 * given.cwiseAbs().maxCoeff()) return;
  throw nb::value_error((std::string(argument) + ": expected " + expected + "; its entry (" +
                         std::to_string(i) + ", " + std::to_string(j) + ") is off by " + to_text(off))
                            .c_str());
}

void check_rotation(const char* argument, const SO3<>& R) {
  const double off = rotation_error(R);
  if (off <= 1e-6) return;
  throw nb::value_error((std::string(argument) +
                         ": expected a rotation, an orthogonal matrix with determinant 1; it is off by " +
                         to_text(off))
                            .c_str());
}

void check_unit(const char* argument, const char* what, double norm) {
  if (std::abs(norm - 1) <= 1e-6) return;
  throw nb::value_error(
      (std::string(argument) + ": expected a " + what + ", got one of length " + to_text(norm)).c_str());
}

Shape first_axes(const Numbers& numbers, int axes) {
  constexpr int most = Shape::most - 2;
  if (axes > most)
    numbers.wrong_shape("with at most " + std::to_string(most) + " axes in front of those of an item");
  Shape lengths{};
  for (int axis = 0; axis < axes; ++axis)
    lengths.length[static_cast<std::size_t>(lengths.axes++)] = numbers.length(axis);
  return lengths;
}

Operand::Operand(const char* name, ArrayLike given, const Shape& item, Infinities infinities)
    : name_(name), numbers_(name, given, infinities) {
  if (!numbers_.ends_with(item)) {
    std::string lengths = "...";
    for (int axis = 0; axis < item.axes; ++axis)
      lengths += ", " + std::to_string(item.length[static_cast<std::size_t>(axis)]);
    numbers_.wrong_shape("(" + lengths + ")");
  }
  leading_ = first_axes(numbers_, numbers_.axes() - item.axes);
  if (leading_.axes > 0) step_ = item.size();
}

Shape common_leading(std::span<const Operand> operands) {
  const Operand* first = &operands.front();
  for (const Operand& operand : operands.subspan(1)) {
    if (operand.leading().axes == 0) continue;
    if (first->leading().axes == 0)
      first = &operand;
    else if (operand.leading().text() != first->leading().text())
      throw nb::value_error((std::string(first->name()) + " has shape " + first->shape_text() + " and " +
                             operand.name() + " has shape " + operand.shape_text() +
                             "; expected the same leading axes, or none in one of them")
                                .c_str());
  }
  return first->leading();
}

Shape with_item(const Shape& leading, const Shape& item) {
  Shape both = leading;
  for (int axis = 0; axis < item.axes; ++axis)
    both.length[static_cast<std::size_t>(both.axes++)] = item.length[static_cast<std::size_t>(axis)];
  return both;
}

void rethrow_with_place(const nb::builtin_exception& error, const Shape& leading, nb::ssize_t k) {
  if (leading.axes == 0) throw error;
  std::string at;
  for (int axis = leading.axes - 1; axis >= 0; --axis) {
    const nb::ssize_t n = leading.length[static_cast<std::size_t>(axis)];
    at = std::to_string(k % n) + (at.empty() ? "" : ", ") + at;
    k /= n;
  }
  throw nb::builtin_exception(error.type(), ("item [" + at + "]: " + error.what()).c_str());
}

}  // namespace axode::python
