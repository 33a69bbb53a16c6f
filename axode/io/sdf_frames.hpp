#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/fault.hpp"

/// The named frames of an SDFormat file: models, links, joints and frames, the poses of which are relative to each other.
namespace axode::io {

class SdfFrames {
 public:
  enum class Kind { world, model, link, joint, frame };
  struct Frame {
    Kind kind{};
    std::string path = {};         ///< with the names of the models that hold it, `arm::hand::palm`
    int model = 0;                 ///< the frame of the model that holds it, 0 for the world
    SE3<> X = {};                  ///< as given; in the pose of a model that of its placement frame
    std::string relative_to = {};  ///< empty: as the kind has it
    std::string attached_to = {};  ///< what a joint, frame or model moves with; empty: as the kind has it
    std::string placement = {};    ///< the frame of a model that its pose is about; empty: its own
    int line = 0;

    SE3<> pose = {};     ///< in the world
    int on = 0;          ///< what X is relative to
    int moves_with = 0;  ///< the link; 0 for the world
  };
  /// Told what is wrong with a frame.
  using Report = std::function<void(Rule, const Frame&, std::string message)>;

  SdfFrames() { add({.kind = Kind::world, .path = "world"}); }

  /// Its number, also where its name is taken: then it cannot be found by its name, and `is_new` is false.
  int add(Frame frame, bool* is_new = nullptr);
  /// The frame that a name means within a model; -1 where there is none.
  int find(int model, std::string_view name) const;
  /// `; did you mean "palm"?` among the names within a model.
  std::string nearest(int model, std::string_view name);

  Frame& operator[](int k) { return all_[static_cast<std::size_t>(k)]; }
  const Frame& operator[](int k) const { return all_[static_cast<std::size_t>(k)]; }
  int size() const { return static_cast<int>(all_.size()); }

  /// Finds what poses are relative to and what frames move with, and computes `pose`.
  void resolve(const Report& report);

 private:
  std::string path(int model, std::string_view name) const;
  /// The frames in an order in which each follows that which `next` names; those of a cycle are cut off, to the world.
  std::vector<int> in_order(int Frame::*next, std::string_view in_a_cycle, const Report& report);

  std::vector<Frame> all_;
  std::unordered_map<std::string, int> by_path_;
  std::vector<int> first_link_;  ///< of each model, nested ones included; 0 where it has none
  int suggestions_ = 0;
};

}  // namespace axode::io
