#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The coordinate along which a drive acts: l = Σ factor q over joints, or the length of a line between
/// points of two bodies. Its rate is w = l' = E v with a row vector E of nv entries.
class DrivePort {
 public:
  /// Constructs the coordinate Σ factor q of `joints`, names with factors, for the drive with the given name.
  /// Throws std::invalid_argument for a joint that does not exist or does not have one velocity.
  DrivePort(const Model& model, const std::string& drive,
            std::span<const std::pair<std::string, double>> joints);
  explicit DrivePort(const Spring::Path& line) : line_(line), along_line_(true) {}

  /// Whether the port is a line between two points. The row E depends on q only then.
  bool is_line() const { return along_line_; }

  /// Computes the coordinate l, the rate w and the row E of the port at a state (q, v).
  void update(const Tree<double>& tree, std::span<const double> q, std::span<const double> v);
  double l() const { return l_; }
  double w() const { return w_; }
  /// The row vector E of the last update(), with which the rate of the coordinate l of the drive (an angle or
  /// a length) is l' = E v. Each pair has the index of a velocity and an entry of E. If an index occurs
  /// several times, its entries must be added.
  std::span<const std::pair<int, double>> row() const { return row_; }

  /// Adds `factor` times the derivative by q of the row vector E to `out` (nv × nv) (D17.3), where E gives
  /// the rate l' = E v of the coordinate l along which the drive acts. Entry [i, j] is the derivative of
  /// entry i of E along the left-trivialised direction of velocity j.
  void add_row_derivatives(const Tree<double>& tree, std::span<const double> q, double factor,
                           std::span<double> out);

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
  /// If the port is a line between two points, this has a pair for each entry of row(): the number (0 or 1)
  /// of the end of the line that a joint velocity moves, and the velocity of this end for a unit of the joint
  /// velocity, in the axes of the body at this end. Joints that move both ends do not change the length and
  /// have no entries; coupled joints have entries of their own.
  std::vector<std::pair<std::size_t, Vec3<>>> columns_;
  /// The motion of one end of a line between two points for a unit of velocity c, for add_row_derivatives().
  /// `end` (0 or 1) is the end that moves, and `body` the body whose joint has velocity c. w is the angular
  /// velocity of the body at this end, and r the rate of the vector from end 0 to end 1, both relative to the
  /// body where the paths from the two ends to the ground meet, and in its axes.
  struct Column {
    std::size_t end;
    int body, c;
    Vec3<> w, r;
  };
  std::vector<Column> derived_;
};

}  // namespace axode
