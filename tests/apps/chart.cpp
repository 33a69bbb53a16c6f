#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/apps/run_command.hpp"
#include "tests/apps/texts_of_svg.hpp"

/// Pictures of motions, sweeps, poles and costs, and the sweeps of `axode eval`.
namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string two_bars = robot("double_pendulum.toml");
const std::string lifted = R"({"q": {"pin": 2, "elbow": 0.5}, "v": [0.1, 0.2]})";

TEST(Plot, OfAMotionHasCoordinatesVelocitiesForcesAndEnergies) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.svg");
  const Outcome outcome =
      axode({"simulate", two_bars, "--state", "-", "--plot", file, "--pd", "30,4"}, lifted);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const std::vector<std::string> texts = texts_of(file);
  for (const char* said : {"double pendulum", "q, rad", "v, rad/s", "tau, N m", "energy, J", "t, s", "pin",
                           "elbow", "kinetic", "potential", "total"})
    EXPECT_THAT(texts, Contains(said));
  ASSERT_EQ(axode({"simulate", two_bars, "--state", "-", "--plot", file}, lifted).code, 0);
  EXPECT_THAT(texts_of(file), Not(Contains("tau, N m"))) << "there are none";
}

TEST(Plot, IsThePictureThatItsEndingSays) {
  const TemporaryFolder folder;
  const std::string png = folder.file("run.png"), again = folder.file("again.svg"),
                    svg = folder.file("run.svg");
  for (const std::string& file : {png, svg, again})
    ASSERT_EQ(axode({"simulate", two_bars, "--until", "0.1", "--plot", file}).code, 0);
  const std::string bytes = contents(png);
  ASSERT_GT(bytes.size(), 24);
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const auto number = [&](std::size_t at) {
    int n = 0;
    for (std::size_t k = at; k < at + 4; ++k) n = 256 * n + static_cast<unsigned char>(bytes[k]);
    return n;
  };
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.LoadFile(svg.c_str()), tinyxml2::XML_SUCCESS);
  EXPECT_EQ(number(16), 2 * document.RootElement()->IntAttribute("width"));
  EXPECT_EQ(number(20), 2 * document.RootElement()->IntAttribute("height"));
  EXPECT_EQ(contents(svg), contents(again));
}

TEST(Plot, ShowsNamesAsTheyAreWhateverIsInThem) {
  const TemporaryFolder folder;
  const std::string trap = folder.file("trap");
  const std::vector<std::string> names{"'; system('x') #", "a\"; set output \"b", "`touch x`",
                                       "@a $HOME %d -0",   "{/Symbol b}_c^d~e",   "back\\slash \\101",
                                       "<b>&amp;",         "Müller ∂ 回"};
  std::string drawing = "format = \"axode drawing 1\"\nname = '''`touch " + trap + "`'''\n";
  for (const std::string& name : names)
    drawing += "[[body]]\nname = '''b" + name + "'''\njoint = { name = '''" + name +
               "''', kind = \"revolute\", axis = \"y\", point = [0, 0, 0] }\nmass = 1\ncom = [1, 0, "
               "0]\ninertia = [1, 1, "
               "1]\n";
  const std::string model = folder.write("trap.toml", drawing), file = folder.file("trap.svg");
  const Outcome outcome = axode({"simulate", model, "--until", "0.1", "--plot", file});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> texts = texts_of(file);
  EXPECT_THAT(texts, Contains("`touch " + trap + "`"));
  for (const std::string& name : names) EXPECT_THAT(texts, Contains(name));
  EXPECT_FALSE(std::filesystem::exists(trap));
}

TEST(Plot, OfManyJointsHasThoseThatMoveMostAndOfLongMotionsWhatCanBeSeen) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.svg");
  ASSERT_EQ(
      axode({"simulate", robot("humanoid.urdf"), "--base", "free", "--until", "0.05", "--plot", file}).code,
      0);
  EXPECT_THAT(texts_of(file), Contains("the 8 of 31 that change most"));
  for (const char* said : {"q, rad", "q, quaternion", "q, m", "v, rad/s", "v, m/s"})
    EXPECT_THAT(texts_of(file), Contains(said));
  EXPECT_THAT(texts_of(file), testing::Contains(testing::EndsWith(" qw")));
  ASSERT_EQ(
      axode({"simulate", two_bars, "--state", "-", "--until", "10", "--samples", "200000", "--plot", file},
            lifted)
          .code,
      0);
  texts_of(file);
  EXPECT_LT(std::filesystem::file_size(file), 1 << 20);
}

TEST(Plot, HasTheColumnsThatAreNamed) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg"), csv = folder.file("run.csv"), machine = robot("machine.toml");
  const auto drawn = [&](const std::string& columns) {
    const Outcome outcome =
        axode({"simulate", machine, "--until", "0.01", "--plot", svg, "--columns", columns, "--output", csv});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return texts_of(svg);
  };
  EXPECT_THAT(drawn("energy"),
              testing::AllOf(Contains("energy, J"), Contains("t, s"), Not(Contains("q, rad"))));
  EXPECT_THAT(drawn("q feed,energy"),
              testing::AllOf(Contains("q, rad"), Contains("feed"), Not(Contains("v, rad/s")),
                             Not(Contains("jack")), Contains("energy, J")));
  EXPECT_THAT(drawn("air bearing"), testing::AllOf(Contains("q, m"), Contains("air bearing x"),
                                                   Contains("air bearing angle"), Not(Contains("feed"))));
  EXPECT_THAT(drawn("table"), testing::AllOf(Contains("air bearing vy"), Not(Contains("energy, J"))));
  EXPECT_EQ(axode({"plot", csv, "--output", svg, "--columns", "feed"}).code, 0);
  EXPECT_THAT(texts_of(svg), testing::AllOf(Contains("feed"), Not(Contains("jack"))));
  ASSERT_EQ(axode({"eval", machine, "--state", csv, "--want", "inverse_dynamics,poses", "--frame",
                   "drill tip", "--plot", svg})
                .code,
            0);
  for (const char* said : {"inverse_dynamics; N m", "inverse_dynamics; N", "poses; m", "poses; quaternion"})
    EXPECT_THAT(texts_of(svg), Contains(said));
  EXPECT_THAT(axode({"plot", csv, "--output", svg, "--columns", "fed"}).err,
              HasSubstr("--columns: \"fed\" is none of "));
}

/// Names are checked before a motion is computed and written; those of contacts are known by then, too.
TEST(Plot, RefusesAWrongColumnBeforeTheMotion) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg"), csv = folder.file("run.csv"),
                    quadruped = robot("quadruped.toml");
  const auto columns = [&](const std::string& names) {
    return axode(
        {"simulate", quadruped, "--until", "0.01", "--plot", svg, "--columns", names, "--output", csv});
  };
  EXPECT_THAT(columns("energy,FL fot").err, HasSubstr("--columns: \"FL fot\" is none of "));
  EXPECT_FALSE(std::filesystem::exists(csv));
  EXPECT_EQ(columns("normal force,energy,FL hip pitch").err, "");
  EXPECT_TRUE(std::filesystem::exists(csv));
  const Outcome no_plot = axode({"simulate", quadruped, "--until", "0.01", "--columns", "energy"});
  EXPECT_NE(no_plot.code, 0);
  EXPECT_THAT(no_plot.err, HasSubstr("--columns requires --plot"));
}

TEST(Plot, HasCurvesInTheColoursOfTheirBodies) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("run.csv"), svg = folder.file("run.svg");
  const auto has = [&](const char* color) { return contents(svg).find(color) != std::string::npos; };
  const auto of_second_body = [&] { return has("rgb(217, 162,  27)") && !has("rgb( 59, 130, 196)"); };
  const auto draw = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--columns", "q elbow"});
    EXPECT_EQ(axode(words).err, "");
  };
  draw({"simulate", two_bars, "--until", "0.1", "--output", csv, "--plot", svg});
  EXPECT_TRUE(of_second_body());
  draw({"plot", csv, "--output", svg});
  EXPECT_FALSE(of_second_body()) << "a table alone does not say which bodies there are";
  draw({"plot", csv, "--output", svg, "--model", two_bars});
  EXPECT_TRUE(of_second_body());
}

TEST(Plot, OfALinearSystemHasItsPolesAndFrequencies) {
  const TemporaryFolder folder;
  const std::string file = folder.file("poles.svg");
  ASSERT_EQ(axode({"linearize", two_bars, "--plot", file}).code, 0);
  for (const char* said : {"double pendulum: marginal", "real part, 1/s", "imaginary part, rad/s", "keeps on",
                           "mode", "natural frequency, Hz"})
    EXPECT_THAT(texts_of(file), Contains(said));
  ASSERT_EQ(
      axode({"linearize", two_bars, "--state", "-", "--equilibrium", "--plot", file}, R"({"q": {"pin": 3}})")
          .code,
      0);
  EXPECT_THAT(texts_of(file), Contains("double pendulum: unstable"));
  EXPECT_THAT(texts_of(file), Contains("grows"));
}

TEST(Plot, NeedsGnuplotBeforeAnythingIsComputed) {
  const std::vector<std::vector<std::string>> commands{{"simulate", "no.toml"},
                                                       {"linearize", "no.toml"},
                                                       {"study", "no.toml"},
                                                       {"eval", "no.toml", "--state", "no.csv"}};
  for (std::vector<std::string> words : commands) {
    words.insert(words.begin(), {"env", "PATH=/nowhere", AXODE_COMMAND});
    words.insert(words.end(), {"--plot", "run.svg"});
    const Outcome without = run(words);
    EXPECT_EQ(without.code, 1);
    EXPECT_EQ(
        without.err,
        "axode " + words[3] +
            ": --plot: charts need gnuplot, which is not installed (on Debian: apt install gnuplot-nox)\n");
  }
}

// ------------------------------------------------------------------------------------------------ axode plot

TEST(PlotOfATable, HasAPanelForEachFirstWordAndTablesSideBySide) {
  const TemporaryFolder folder;
  const std::string run_csv = folder.file("run.csv"), svg = folder.file("run.svg");
  ASSERT_EQ(axode({"simulate", two_bars, "--until", "0.1", "--output", run_csv}).code, 0);
  const Outcome outcome = axode({"plot", run_csv, "--output", svg});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, svg + ": curves of " + run_csv + "\n");
  for (const char* said : {"run", "t", "q", "v", "a", "tau", "energy", "pin", "elbow"})
    EXPECT_THAT(texts_of(svg), Contains(said));
  const std::string errors = folder.write(
      "errors.csv", "steps,\"error, rad: rk 4\",\"error, rad: dopri5\"\n10,1e-3,\n1000,1e-11,1e-5\n");
  ASSERT_EQ(axode({"plot", errors, run_csv, "--output", svg}).code, 0);
  for (const char* said : {"errors", "run", "steps", "error, rad", "rk 4", "dopri5", "1000", "energy"})
    EXPECT_THAT(texts_of(svg), Contains(said));
  ASSERT_EQ(axode({"plot", errors, "--output", svg, "--log", "xy"}).code, 0);
  for (const char* said : {"errors", "steps", "error, rad", "rk 4", "dopri5", "1e-11", "1e1"})
    EXPECT_THAT(texts_of(svg), Contains(said));
}

/// The left and right ends of all rectangles that are filled with a colour.
std::vector<std::pair<double, double>> bars_in(const std::string& file, const std::string& color) {
  const std::string svg = contents(file);
  std::vector<std::pair<double, double>> bars;
  const std::regex polygon("<polygon fill = 'rgb\\(" + color + "\\)' points = '([^']*)'");
  for (std::sregex_iterator found(svg.begin(), svg.end(), polygon), end; found != end; ++found) {
    std::istringstream corners((*found)[1]);
    double x = 0, y = 0, low = 1e9, high = -1e9;
    for (char comma = 0; corners >> x >> comma >> y;) low = std::min(low, x), high = std::max(high, x);
    bars.emplace_back(low, high);
  }
  return bars;
}

TEST(PlotOfATable, HasBarsOfEachNameBesideEachOther) {
  const TemporaryFolder folder;
  const std::string csv = folder.write("ratios.csv",
                                       "model,ratio one,ratio two\narm,1,2\nhumanoid,3,4\nleg,,5\n"),
                    svg = folder.file("ratios.svg");
  ASSERT_EQ(axode({"plot", csv, "--bars", "--output", svg}).code, 0);
  for (const char* said : {"model", "ratio", "one", "two", "arm", "humanoid", "leg"})
    EXPECT_THAT(texts_of(svg), Contains(said));
  auto first = bars_in(svg, " 59, 130, 196"), second = bars_in(svg, "217, 162,  27");
  std::erase_if(first, [](const auto& bar) { return bar.second - bar.first < 30; });  // those of the legend
  std::erase_if(second, [](const auto& bar) { return bar.second - bar.first < 30; });
  ASSERT_EQ(first.size(), 2);
  ASSERT_EQ(second.size(), 3);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(first[k].second, second[k].first, 2);
    EXPECT_LT(second[k].second, second[k + 1].first);
  }
}

TEST(PlotOfATable, HasNumbersThatDifferBesideItsAxes) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg");
  const auto drawn = [&](const std::string& table) {
    EXPECT_EQ(axode({"plot", "-", "--output", svg}, table).err, "");
    return texts_of(svg);
  };
  EXPECT_THAT(drawn("t,e\n0,1.16563\n1,1.165630002\n"),
              testing::IsSupersetOf({"1.1656300000", "1.1656300002", "1.1656300004", "1.1656300020"}));
  EXPECT_THAT(drawn("t,e\n0,0.2\n1,-0.3\n"), testing::IsSupersetOf({"0.20", "0.15", "0.00", "-0.30"}));
  EXPECT_THAT(drawn("t,e\n1000000.25,0\n1000001,2e-8\n"),
              testing::IsSupersetOf({"1000000.4", "1000001.0", "2.0e-9", "2.0e-8"}));
  EXPECT_THAT(drawn("t,e\n0,7\n1,7\n2,7\n"), testing::IsSupersetOf({"6.94", "7.00", "7.06"}));
  EXPECT_THAT(drawn("t,e\n0,0\n1,0\n"), testing::IsSupersetOf({"-1.0", "0.0", "1.0"}));
}

TEST(PlotOfATable, HasRoomForLongNumbers) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg");
  ASSERT_EQ(axode({"plot", "-", "--output", svg}, "t,energy\n0,1.16563\n1,1.165630002\n").code, 0);
  const std::string text = contents(svg);
  std::smatch label, number;
  const std::string at = R"(translate\(([0-9.]+),[0-9.]+\))";
  const std::regex of_label(at + R"~( rotate\(-90\)"[^>]*>\s*<text>energy)~"),
      of_number(at + R"~("[^>]*text-anchor="end">\s*<text>1\.165630)~");
  ASSERT_TRUE(std::regex_search(text, label, of_label));
  ASSERT_TRUE(std::regex_search(text, number, of_number));
  const double width = 12 * 0.6 * 12;  // of twelve characters of 12 pixels
  EXPECT_LT(std::stod(label[1]) + 6, std::stod(number[1]) - width);
}

TEST(PlotOfATable, HasAUnitInEachPanelIfTheModelIsKnown) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("run.csv"), svg = folder.file("run.svg"),
                    machine = robot("machine.toml");
  ASSERT_EQ(axode({"simulate", machine, "--until", "0.1", "--output", csv}).code, 0);
  const Outcome outcome = axode({"plot", csv, "--model", machine, "--output", svg});
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(texts_of(svg),
              testing::IsSupersetOf({"q, rad", "q, m", "q, quaternion", "v, rad/s", "v, m/s", "a, rad/s^2",
                                     "a, m/s^2", "tau, N m", "tau, N", "energy, J", "t, s", "air bearing x",
                                     "ball qw", "feed"}));
  ASSERT_EQ(axode({"plot", csv, "--model", machine, "--output", svg, "--columns", "q table,energy"}).code, 0);
  EXPECT_THAT(texts_of(svg), testing::AllOf(Contains("air bearing angle"), Contains("q, rad"),
                                            Not(Contains("feed")), Not(Contains("v, m/s"))));
  EXPECT_THAT(axode({"plot", csv, "--base", "free", "--output", svg}).err,
              HasSubstr("--base requires --model"));
}

TEST(PlotOfATable, LeavesOutWhatCannotBeDrawn) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg");
  const std::string csv = folder.write("x.csv", "x,y a,y b\n1,nan,\n0,1,inf\n-1,2,3\n2,0,\n");
  EXPECT_EQ(axode({"plot", csv, "--output", svg}).code, 0);
  EXPECT_EQ(axode({"plot", csv, "--output", svg, "--log", "xy"}).err,
            "axode plot: --output: there are no numbers to draw\n");
  const std::string tiny = folder.write("tiny.csv", "x,y\n1,5e-324\n2,1e-310\n3,1e-300\n4,1e300\n");
  const Outcome drawn = axode({"plot", tiny, "--output", svg, "--log", "y"});
  EXPECT_EQ(drawn.err, "");
  for (const char* said : {"1e-300", "1e300", "3.0", "4.0"}) EXPECT_THAT(texts_of(svg), Contains(said));
  EXPECT_THAT(texts_of(svg), Not(Contains("1")));
  EXPECT_EQ(axode({"plot", "-", "--output", svg}, "x,y\n1,2\n").code, 0);
}

TEST(PlotOfATable, HasNumbersBelowLogarithmicAxesOfLessThanADecade) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg"), csv = folder.write("x.csv", "x,y\n2,30\n8,40\n");
  ASSERT_EQ(axode({"plot", csv, "--output", svg, "--log", "xy"}).code, 0);
  for (const char* said : {"1e0", "1e1", "1e2"}) EXPECT_THAT(texts_of(svg), Contains(said));
}

TEST(PlotOfATable, HatchesBarsWhoseColourComesAgain) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg");
  const auto draw = [&](int bars) {
    std::string headings = "name", numbers = "arm";
    for (int k = 0; k < bars; ++k) headings += ",r c" + std::to_string(k), numbers += ",1";
    EXPECT_EQ(axode({"plot", "-", "--bars", "--output", svg}, headings + "\n" + numbers + "\n").code, 0);
    return contents(svg);
  };
  EXPECT_THAT(draw(10), Not(HasSubstr("url(#gpPat")));
  const std::string many = draw(21);
  EXPECT_THAT(many, HasSubstr("url(#gpPat1"));
  EXPECT_THAT(many, HasSubstr("url(#gpPat2"));
}

TEST(PlotOfATable, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  const std::string svg = folder.file("x.svg");
  const auto error = [&](const std::string& text, std::vector<std::string> words = {}) {
    const std::string file = folder.write("x.csv", text);
    words.insert(words.begin(), {"plot", file, "--output", svg});
    const Outcome outcome = axode(words);
    EXPECT_NE(outcome.code, 0);
    EXPECT_FALSE(std::filesystem::exists(svg));
    std::string err = outcome.err.substr(std::string("axode plot: ").size());
    return err.starts_with(file) ? err.substr(file.size()) : err;
  };
  EXPECT_EQ(error(""), ": expected a line with the names of columns, and numbers below it\n");
  EXPECT_EQ(error("t,q\n"), ": expected a line with the names of columns, and numbers below it\n");
  EXPECT_EQ(error("t\n1\n"),
            ": there is only one column; the first one is the horizontal axis, and the others are drawn\n");
  EXPECT_EQ(error("t,q\n1,2\n\n3\n"), ":4: there are 1 columns; the first line has 2\n");
  EXPECT_EQ(error("t,q\n1,two\n"), ":2: \"two\" is not a number\n");
  EXPECT_EQ(error("0,1\n1,2\n"), ": the first line has numbers; write the names of the columns there\n");
  std::string words = "t";
  for (int k = 0; k < 61; ++k) words += ",c" + std::to_string(k) + " x";
  EXPECT_EQ(
      error(words + "\n"),
      ": its columns make 61 panels, one of each first word; a chart has 60 places, 60 for this table\n");
  words.resize(words.rfind(','));
  folder.write("other.csv", words + "\n");
  EXPECT_THAT(error("t,q\n1,2\n", {folder.file("other.csv")}),
              HasSubstr("other.csv: its columns make 60 panels, one of each first word; a chart has 60 "
                        "places, 30 for this table"));
  EXPECT_EQ(error("t,\"q\nq\"\nx,2\n"), ":3: \"x\" is not a number\n");
}

// ---------------------------------------------------------------------------------------------------- sweeps

TEST(Sweep, IsWhatEachOfItsStatesGivesAlone) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("run.csv"), json = folder.file("run.json"),
                    svg = folder.file("run.svg");
  const std::string machine = robot("machine.toml"), wanted = "inverse_dynamics,poses,kinetic_energy";
  ASSERT_EQ(
      axode({"simulate", machine, "--until", "0.1", "--samples", "3", "--output", csv, "--output", json})
          .code,
      0);
  const Outcome sweep =
      axode({"eval", machine, "--state", csv, "--want", wanted, "--format", "json", "--plot", svg});
  ASSERT_EQ(sweep.code, 0) << sweep.err;
  const Json all = Json::parse(sweep.out), motion = Json::parse(contents(json));
  EXPECT_EQ(all.at("t"), motion.at("t"));
  for (std::size_t i = 0; i < 4; ++i) {
    Json state;
    for (const char* key : {"q", "v", "a", "tau"}) state[key] = motion.at(key)[i];
    const Outcome one =
        axode({"eval", machine, "--state", "-", "--want", wanted, "--format", "json"}, state.dump());
    const Json results = Json::parse(one.out).at("results");
    for (const auto& [name, value] : results.items()) EXPECT_EQ(all.at("results").at(name)[i], value) << name;
  }
  EXPECT_THAT(texts_of(svg), Contains("kinetic_energy; J"));
  EXPECT_THAT(texts_of(svg), Contains("t, s"));
}

TEST(Sweep, ShowsWhereNumbersAreSmallestAndLargest) {
  const TemporaryFolder folder;
  const std::string states = folder.write("states.csv", "\"q pin\",v elbow\r\n0,1\r\n1.5,-3\r\n\r\n-1,2\r\n");
  const Outcome shown = axode({"eval", two_bars, "--state", states, "--want", "kinetic_energy,poses"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, StartsWith("double pendulum: 3 states, numbered from 0 to 2\n"));
  EXPECT_THAT(shown.out, testing::ContainsRegex("smallest +at state +largest +at state"));
}

TEST(Sweep, EntriesOfAMatrixHaveTheUnitsOfBothOfTheirVelocities) {
  const TemporaryFolder folder;
  const std::string csv = folder.write("run.csv", "t,q quill.translation\n0,0\n1,0.1\n"),
                    svg = folder.file("x.svg");
  const auto texts = [&](const std::string& column) {
    const Outcome outcome = axode({"eval", robot("machine.toml"), "--state", csv, "--want", "mass_matrix",
                                   "--plot", svg, "--columns", column});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return texts_of(svg);
  };
  EXPECT_THAT(texts("quill.translation quill.translation"),
              AllOf(Contains("mass_matrix; kg"), Not(Contains("mass_matrix; kg m"))));
  EXPECT_THAT(texts("jack quill.translation"),
              AllOf(Contains("mass_matrix; kg m"), Not(Contains("mass_matrix; kg"))));
  EXPECT_THAT(texts("jack jack"), AllOf(Contains("mass_matrix; kg m^2"), Not(Contains("mass_matrix; kg m"))));
}

TEST(Sweep, NamesWhatIsWrongWithItsFile) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    const std::string file = folder.write("states.csv", text);
    const Outcome outcome = axode({"eval", two_bars, "--state", file});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(outcome.out, "");
    std::string err = outcome.err;
    for (std::size_t at; (at = err.find("axode eval: " + file + ": ")) != std::string::npos;)
      err.erase(at, ("axode eval: " + file + ": ").size());
    return err;
  };
  EXPECT_EQ(error(""), "expected a line with the names of columns, and states below it\n");
  EXPECT_EQ(error("t,q pin\n"), "expected a line with the names of columns, and states below it\n");
  EXPECT_EQ(error("q pni,v pin,w\n0,0,0\n"),
            "the column \"q pni\" has no meaning here; columns are t, and q, v, a, jerk, snap and tau, each "
            "followed by a name; did you mean "
            "\"q pin\"?\n"
            "the column \"w\" has no meaning here; columns are t, and q, v, a, jerk, snap and tau, each "
            "followed by "
            "a name\n");
  EXPECT_EQ(error("t,t\n0,0\n"), "the column \"t\" is given more than once\n");
  EXPECT_EQ(error("t,q pin\n0,0\n1\n"), "state 1: has 1 number, and there are 2 columns\n");
  EXPECT_EQ(error("t,q pin\n0,x\n"), "state 0: q pin is \"x\", which is not a finite number\n");
  EXPECT_EQ(error("t,q pin\n0,nan\n"), "state 0: q pin is \"nan\", which is not a finite number\n");
  EXPECT_THAT(error("t,\"q pin\n0,0\n"), HasSubstr(":1: a quote (\") is opened here and never closed\n"));
}

}  // namespace
}  // namespace axode::test
