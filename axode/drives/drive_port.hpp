#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The port of a drive: a sum of joint coordinates, or the length of a line between two points.
class DrivePort {
 public:
  /// A sum of joint coordinates with factors. Throws std::invalid_argument, which names `drive`, for an
  /// unknown joint and for a joint that does not have one velocity.
  DrivePort(const Model& model, const std::string& drive,
            std::span<const std::pair<std::string, double>> joints);
  explicit DrivePort(const Spring::Path& line) : line_(line), along_line_(true) {}

  /// Whether the row E depends on q.
  bool is_line() const { return along_line_; }

  /// Computes the coordinate, its rate and the row E at a state.
  void update(const Tree<double>& tree, std::span<const double> q, std::span<const double> v);
  double l() const { return l_; }
  double w() const { return w_; }
  /// The row E with l' = E v: indices of velocities with their entries. An index may occur more than once.
  std::span<const std::pair<int, double>> row() const { return row_; }

  /// Adds factor times the derivatives of the row E by q along the group to out, nv × nv: [component of E,
  /// direction] (D17.3).
  void add_row_derivatives(const Tree<double>& tree, std::span<const double> q, double factor,
                           std::span<double> out) const;

 private:
  struct Term {
    int velocity, coordinate;
    double factor, offset;
  };

  std::vector<Term> terms_;
  Spring::Path line_;
  bool along_line_ = false;
  double l_ = 0, w_ = 0;
  std::vector<std::pair<int, double>> row_;
  std::vector<std::pair<std::size_t, Vec3<>>> columns_;  ///< of a line: its end, and the column of a velocity
};

}  // namespace axode
