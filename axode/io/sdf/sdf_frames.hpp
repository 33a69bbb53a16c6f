#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/building/fault.hpp"

/// The frames of an SDF file: models, links, joints and named frames, with poses relative to each other.
namespace axode::io {

class SdfFrames {
 public:
  enum class Kind { world, model, link, joint, frame };
  struct Frame {
    Kind kind{};
    std::string path = {};         ///< name with those of the models around it, `arm::hand::palm`
    int model = 0;                 ///< number of the model in which it is, 0 for the world
    SE3<> X = {};                  ///< pose as given; of the placement frame for a model until resolve()
    std::string relative_to = {};  ///< name of the frame to which X is relative; empty for the default
    std::string attached_to = {};  ///< name of the link or frame with which a joint, frame or model moves;
                                   ///< empty for the default
    std::string placement = {};    ///< name of a model's placement frame; empty: the model frame itself
    int line = 0;

    // The following members are computed by resolve().
    SE3<> pose = {};     ///< pose in the world
    int on = 0;          ///< number of the frame to which X is relative
    int moves_with = 0;  ///< number of the link that the frame is fixed to; 0 for the world
  };
  /// A function that is called for each fault of a frame, with the rule, the frame and the message.
  using Report = std::function<void(Rule, const Frame&, std::string message)>;

  SdfFrames() { add({.kind = Kind::world, .path = "world"}); }

  /// Adds a frame and returns its number. If its path is taken, `is_new` is false, and find() ignores it.
  int add(Frame frame, bool* is_new = nullptr);
  /// The number of the frame with a name in a model (by its number, 0 for the world); -1 if there is none.
  int find(int model, std::string_view name) const;
  /// A text such as `; did you mean "palm"?` with a similar name in the model, or an empty text.
  std::string nearest(int model, std::string_view name);

  Frame& operator[](int k) { return all_[static_cast<std::size_t>(k)]; }
  const Frame& operator[](int k) const { return all_[static_cast<std::size_t>(k)]; }
  int size() const { return static_cast<int>(all_.size()); }

  /// Computes for each frame the link to which it is fixed and its pose in the world, from the frames
  /// relative to which they are given. Calls `report`, and then goes on, for each unknown name, for each
  /// cycle of frames, and for each frame that places a model (attribute `placement_frame` of SDFormat) if
  /// this frame is not given relative to the model itself.
  void resolve(const Report& report);

 private:
  std::string path(int model, std::string_view name) const;
  /// The indices of the frames in an order in which each frame comes after the frame that its member `next`
  /// names. For each cycle, calls `report` with the message `in_a_cycle`, and cuts the cycle at one of its
  /// frames.
  std::vector<int> in_order(int Frame::*next, std::string_view in_a_cycle, const Report& report);

  std::vector<Frame> all_;
  std::unordered_map<std::string, int> by_path_;
  std::vector<int> first_link_;  ///< number of the first link in each model and in models inside it; 0: none
  int suggestions_ = 0;
};

}  // namespace axode::io
