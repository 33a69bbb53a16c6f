#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/building/fault.hpp"

/// The named frames of an SDFormat file: models, links, joints and frames, whose poses are relative to each
/// other.
namespace axode::io {

class SdfFrames {
 public:
  enum class Kind { world, model, link, joint, frame };
  struct Frame {
    Kind kind{};
    std::string path = {};         ///< name after those of the models that hold it, `arm::hand::palm`
    int model = 0;                 ///< number of the model that holds it, 0 for the world
    SE3<> X = {};                  ///< pose as given; for a model it is that of the placement frame
    std::string relative_to = {};  ///< name of the frame to which X is relative; empty for the default
    std::string attached_to = {};  ///< name of the link or frame with which a joint, frame or model moves;
                                   ///< empty for the default
    std::string placement = {};    ///< name of a model's placement frame; empty for the frame of the model
    int line = 0;

    // The following members are results of resolve().
    SE3<> pose = {};     ///< pose in the world
    int on = 0;          ///< number of the frame to which X is relative
    int moves_with = 0;  ///< number of the link that the frame is fixed to; 0 for the world
  };
  /// Function that is called with each fault of a frame.
  using Report = std::function<void(Rule, const Frame&, std::string message)>;

  SdfFrames() { add({.kind = Kind::world, .path = "world"}); }

  /// Adds a frame and returns its number. If its name is taken, find() does not find the frame, and `is_new`
  /// is set to false.
  int add(Frame frame, bool* is_new = nullptr);
  /// The number of the frame that a name means within a model; -1 if there is none.
  int find(int model, std::string_view name) const;
  /// `; did you mean "palm"?` with a similar name within the model, or an empty text.
  std::string nearest(int model, std::string_view name);

  Frame& operator[](int k) { return all_[static_cast<std::size_t>(k)]; }
  const Frame& operator[](int k) const { return all_[static_cast<std::size_t>(k)]; }
  int size() const { return static_cast<int>(all_.size()); }

  /// Finds, for each frame, the frame to which its pose is relative and the link with which it moves, and
  /// computes `pose`. Names of frames that do not exist, and cycles, are reported.
  void resolve(const Report& report);

 private:
  std::string path(int model, std::string_view name) const;
  /// The frames in an order in which each comes after the one that `next` names. A cycle is reported and cut:
  /// one of its frames is related to the world instead.
  std::vector<int> in_order(int Frame::*next, std::string_view in_a_cycle, const Report& report);

  std::vector<Frame> all_;
  std::unordered_map<std::string, int> by_path_;
  std::vector<int> first_link_;  ///< first link in each model or a model nested in it; 0 if there is none
  int suggestions_ = 0;
};

}  // namespace axode::io
