#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"

/// `axode view` writes pages that hold the mechanisms and motions that they show.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string two_bodies = robot("double_pendulum.toml");

nlohmann::json scene_in(const std::string& file) {
  const std::string page = contents(file), before = R"(<script id="scene" type="application/json">)";
  const std::size_t from = page.find(before) + before.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

class View : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string_view(AXODE_PAGE).empty())
      GTEST_SKIP() << "this build has no viewer (AXODE_VIEWER is OFF)";
  }
  Outcome view(std::vector<std::string> words, const std::string& input = "") const {
    words.insert(words.begin(), "view");
    return axode(words, input);
  }
  std::string simulated(const std::string& ending) const {
    const std::string file = folder_.file("run." + ending);
    const Outcome outcome =
        axode({"simulate", two_bodies, "--state", "-", "--until", "0.5", "--samples", "20", "--output", file},
              R"({"q": {"pin": 1}})");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return file;
  }

  const TemporaryFolder folder_;
  const std::string page_ = folder_.file("page.html");
};

TEST(ViewCommand, SaysWhereABuildHasNoViewer) {
  if (!std::string_view(AXODE_PAGE).empty()) GTEST_SKIP() << "this build has a viewer";
  const Outcome outcome = axode({"view", two_bodies, "--output", "page.html"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err,
            "axode view: this build of axode has no viewer; configure it with -DAXODE_VIEWER=ON, which takes "
            "npm\n");
}

TEST_F(View, WritesAPageWithTheScene) {
  const Outcome outcome = view({two_bodies, "--output", page_});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, testing::MatchesRegex(".*page.html: [0-9.]+ [kM]B, 2 moving bodies, 0 meshes\n"));
  const nlohmann::json scene = scene_in(page_);
  EXPECT_EQ(scene["name"], "double pendulum");
  EXPECT_EQ(scene["q"], nlohmann::json({2.0, 0.0}));  // the initial state of the drawing
  EXPECT_TRUE(scene["motion"].is_null());
  EXPECT_EQ(contents(page_).find("src=\"http"), std::string::npos);
}

TEST_F(View, ShowsTheStateThatIsGiven) {
  EXPECT_EQ(view({two_bodies, "--state", "-", "--output", page_}, R"({"q": {"elbow": 0.5}})").code, 0);
  EXPECT_EQ(scene_in(page_)["q"], nlohmann::json({0.0, 0.5}));
}

TEST_F(View, WarnsThatALoopIsOpen) {
  const std::string file = robot("four_bar.toml"), open = R"({"q": {"crank_joint": 0.5}})";
  const Outcome outcome = view({file, "--state", "-", "--output", page_}, open);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, StartsWith("warning: q leaves loop \"pin\" open by "));
  EXPECT_EQ(scene_in(page_)["q"], nlohmann::json({0.5, 0.0, 0.0}));
  const Outcome strict = view({file, "--state", "-", "--strict", "--output", page_}, open);
  EXPECT_EQ(strict.code, 1);
  EXPECT_THAT(strict.err, StartsWith("axode view: q leaves loop \"pin\" open by "));
  EXPECT_EQ(view({file, "--output", page_}).err, "");
}

TEST_F(View, ShowsTheMotionOfEveryKindOfFile) {
  for (const char* ending : {"csv", "json", "npz"}) {
    const std::string run = simulated(ending);
    const Outcome outcome = view({two_bodies, "--motion", run, "--output", page_});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json scene = scene_in(page_), motion = scene["motion"];
    const nlohmann::json expected = nlohmann::json::parse(contents(simulated("json")));
    for (const char* what : {"t", "q", "v", "tau"})
      EXPECT_EQ(motion[what], expected[what]) << ending << ' ' << what;
    EXPECT_EQ(scene["q"], expected["q"][0]);
    EXPECT_EQ(motion["twists"].size(), 21U);
    EXPECT_EQ(motion["wrenches"].size(), 21U);
    for (std::size_t k = 0; k < 21; ++k)
      EXPECT_NEAR(motion["series"][0]["values"][k].back().get<double>(), expected["energy"][k].get<double>(),
                  1e-9);
  }
}

/// The loads of a simulation, in the order of their frames, are the same in every kind of file.
TEST_F(View, ShowsTheLoadsOfASimulation) {
  nlohmann::json first;
  for (const char* ending : {"csv", "json", "npz"}) {
    const std::string file = folder_.file(std::string("run.") + ending);
    const Outcome simulated =
        axode({"simulate", robot("arm7.toml"), "--state", "-", "--until", "0.1", "--samples", "4", "--output",
               file},
              R"({"loads": [{"frame": "flange", "representation": "hybrid", "wrench": [0, 0, 0, 0, 0, -20]},
                            {"frame": "link 3", "wrench": [1, 0, 0, 0, 0, 0]},
                            {"frame": "flange", "wrench": [0, 0, 2, 0, 0, 0]}]})");
    ASSERT_EQ(simulated.code, 0) << simulated.err;
    ASSERT_EQ(view({robot("arm7.toml"), "--motion", file, "--output", page_}).code, 0);
    const nlohmann::json motion = scene_in(page_)["motion"];
    ASSERT_EQ(motion["load_frames"].size(), 2U);
    EXPECT_EQ(motion["load_frames"][0]["name"], "link 3");
    EXPECT_EQ(motion["load_frames"][1]["name"], "flange");
    ASSERT_EQ(motion["loads"].size(), 5U);
    EXPECT_EQ(motion["loads"][0],
              nlohmann::json({{1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 2.0, 0.0, 0.0, -20.0}}));
    if (first.is_null()) first = motion["loads"];
    EXPECT_EQ(motion["loads"], first) << ending;
  }
  EXPECT_TRUE(view({two_bodies, "--motion", simulated("csv"), "--output", page_}).err.empty());
  EXPECT_TRUE(scene_in(page_)["motion"]["loads"].is_null());
}

TEST_F(View, AMotionNeedsNoAccelerationsAndForces) {
  const std::string file = folder_.write(
      "run.csv", "\xEF\xBB\xBFt,q pin,\"q elbow\",v pin,v elbow,note\r\n0,1,2,3,4,5\r\n\n1,2,3,4,5,6\n");
  ASSERT_EQ(view({two_bodies, "--motion", file, "--output", page_}).code, 0);
  const nlohmann::json motion = scene_in(page_)["motion"];
  EXPECT_EQ(motion["q"], nlohmann::json({{1.0, 2.0}, {2.0, 3.0}}));
  EXPECT_TRUE(motion["tau"].is_null());
  EXPECT_TRUE(motion["wrenches"].is_null());
}

TEST_F(View, RefusesMotionsThatDoNotFitInOneSentence) {
  const auto error = [&](const std::string& file, const std::string& of = two_bodies) {
    const Outcome outcome = view({of, "--motion", file, "--output", page_});
    EXPECT_NE(outcome.code, 0);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(page_));
    return outcome.err;
  };
  const auto csv = [&](const std::string& text) { return error(folder_.write("a.csv", text)); };
  const auto json = [&](const std::string& text) { return error(folder_.write("a.json", text)); };
  const auto npz = [&](const std::string& text) { return error(folder_.write("a.npz", text)); };
  EXPECT_THAT(error(simulated("csv"), robot("arm7.toml")),
              HasSubstr("there is no q in it; a motion of model \"arm7\" takes 21 x 7"));
  EXPECT_THAT(error(simulated("json"), robot("arm7.toml")),
              HasSubstr("coordinates must be the names of the 7 coordinates of model \"arm7\""));
  EXPECT_THAT(error(simulated("npz"), robot("arm7.toml")),
              HasSubstr("q is 21 x 2; model \"arm7\" takes 21 x 7"));
  EXPECT_THAT(error("none.csv"), HasSubstr("none.csv: the file cannot be read"));
  EXPECT_THAT(error("none.npz"), HasSubstr("none.npz: it cannot be read as an .npz"));
  EXPECT_THAT(error("a.txt"),
              HasSubstr("--motion: a.txt: the ending: \".txt\" is none of .json, .csv, .npz"));
  EXPECT_THAT(csv(""), HasSubstr("there are no times in it"));
  EXPECT_THAT(csv("t,q pin\n0,1\n"), HasSubstr("there is no column \"q elbow\""));
  EXPECT_THAT(csv("t,q pin,q pin,q elbow,v pin,v elbow\n0,1,1,1,1,1\n"),
              HasSubstr("the column \"q pin\" is given more than once"));
  EXPECT_THAT(csv("t,q pin,\"q elbow,v pin,v elbow\n0,1,2,3,4\n"),
              HasSubstr("a.csv:1: a quote (\") is opened here and never closed"));
  EXPECT_THAT(csv("t,q pin,q elbow,v pin,v elbow\n0,1\r2,3,4,5\n"),
              HasSubstr("a.csv:2: there are 2 columns"));
  EXPECT_THAT(csv("t,q p\xEFn\n"), HasSubstr("a.csv:1: a byte is not UTF-8"));
  EXPECT_THAT(csv("t,q pin,q elbow,v pin,v elbow\n0,1,2,3\n"),
              HasSubstr("a.csv:2: there are 4 columns; the first line has 5"));
  EXPECT_THAT(csv("t,q pin,q elbow,v pin,v elbow\n0,1,x,3,4\n"), HasSubstr("a.csv:2: \"x\" is not a number"));
  EXPECT_THAT(csv("t,q pin,q elbow,v pin,v elbow\n0,1,nan,3,4\n"), HasSubstr("must be finite"));
  EXPECT_THAT(csv("t,q pin,q elbow,v pin,v elbow\n1,1,1,1,1\n0,1,1,3,4\n"), HasSubstr("times must increase"));
  EXPECT_THAT(json("{"), HasSubstr("this is not JSON"));
  EXPECT_THAT(json(std::string(100'000, '[')), HasSubstr("nested deeper"));
  EXPECT_THAT(json("[]"), HasSubstr("expected an object with t, q and v"));
  EXPECT_THAT(json(R"({"t": [0], "q": [[1, "x"]], "v": [[1, 2]]})"),
              HasSubstr("q must have a row for each time and a number in each column"));
  EXPECT_THAT(json(R"({"t": [0, 1], "q": [[1, 2], [3]], "v": []})"),
              HasSubstr("q must have a row for each time and a number in each column"));
  EXPECT_THAT(json(R"({"t": [0], "q": [[1, 2]]})"),
              HasSubstr("there is no v in it; a motion of model \"double pendulum\" takes 1 x 2"));
  EXPECT_THAT(json(R"({"coordinates": ["elbow", "pin"], "t": [0], "q": [[1, 2]], "v": [[0, 0]]})"),
              HasSubstr("coordinates[0] is \"elbow\"; that of model \"double pendulum\" is \"pin\""));
  const std::string load_free = R"({"t": [0], "q": [[1, 2]], "v": [[1, 2]], )";
  EXPECT_THAT(
      json(load_free + R"("loads": [[1, 2]]})"),
      HasSubstr("loads is 1 x 2; model \"double pendulum\" takes 1 x 0 (times x 6 per loaded frame)"));
  EXPECT_THAT(json(load_free + R"("load_frames": ["tipp"], "loads": [[1, 2, 3, 4, 5, 6]]})"),
              HasSubstr("`load_frames`: "));
  EXPECT_THAT(json(load_free + R"("load_frames": [7], "loads": [[1, 2, 3, 4, 5, 6]]})"),
              HasSubstr("`load_frames`: "));
  const std::string whole = contents(simulated("npz"));
  for (const std::size_t cut : {std::size_t{0}, std::size_t{10}, whole.size() / 2, whole.size() - 1})
    npz(whole.substr(0, cut));
  std::string other = whole;
  for (std::size_t at; (at = other.find("'<f8'")) != std::string::npos;) other.replace(at, 5, "'<f4'");
  npz(other);
}

TEST_F(View, TellsOfMeshesThatAreMissing) {
  const std::string file = folder_.write("robot.urdf",
                                         "<robot name=\"r\"><link name=\"base\"><visual><geometry><mesh "
                                         "filename=\"a.stl\"/></geometry></visual></link></robot>");
  const Outcome outcome = view({file, "--output", page_});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err,
              StartsWith(file + ":1: warning: body \"base\": mesh \"a.stl\" is not shown: there is no file"));
  folder_.write("a.stl", "solid\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n");
  const Outcome found = view({file, "--output", page_});
  EXPECT_EQ(found.err, "");
  EXPECT_THAT(found.out, HasSubstr("0 moving bodies, 1 meshes\n"));
  EXPECT_THAT(found.out, HasSubstr(folder_.file("a.stl")));
}

TEST_F(View, OpensThePageWhereItIsNotToldAFile) {
  const std::string opener =
      folder_.write("xdg-open", "#!/bin/sh\ncp \"$1\" \"$1.copy\" && mv \"$1.copy\" \"$AXODE_OPENED\"\n");
  std::filesystem::permissions(opener, std::filesystem::perms::owner_all);
  const std::string opened = folder_.file("opened.html");
  const std::string tmp = folder_.file("tmp");
  std::filesystem::create_directory(tmp);
  const auto run_with = [&](const std::string& path) {
    return run({"env", "PATH=" + path, "TMPDIR=" + tmp, "AXODE_OPENED=" + opened, AXODE_COMMAND, "view",
                two_bodies});
  };
  const Outcome outcome = run_with(folder_.path().string() + ":/usr/bin:/bin");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, StartsWith(tmp + "/axode-"));
  for (int k = 0; k < 2000 && !std::filesystem::exists(opened); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(scene_in(opened)["name"], "double pendulum");
  const Outcome alone = run_with(tmp);
  EXPECT_EQ(alone.code, 1);
  EXPECT_THAT(alone.err, HasSubstr("there is neither xdg-open nor open; open " + tmp));
}

}  // namespace
}  // namespace axode::test
