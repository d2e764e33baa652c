#include "libsim/plot/movie.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "libsim/plot/plot.hpp"
#include "libsim/plot/program.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Films of frames. Oracle: ffprobe, which decodes every picture.
namespace subsoil::sim::movie_test {
namespace {

using namespace test;
using subsoil::test::message_of;

constexpr const char* falling = R"(subsoil: 1
materials: {stone: {density: 2500 kg/m^3}}
contacts: [{between: [stone, stone], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3}]
soil:
  container: {size: 100 100 100 mm, at: 0 0 0 m, material: stone}
  bed:
    fill: particles
    material: stone
    particles: [{position: 50 30 50 mm, radius: 10 mm}, {position: 55 55 50 mm, radius: 10 mm}]
boundaries: [{name: paddle, material: stone, shape: {box: 10 40 60 mm}, at: 20 30 50 mm, moves: [{velocity: 0.1 0 0 m/s}]}]
time: {end: 100 ms}
output: {every: 10 ms}
)";

/// What ffprobe says of the first stream: codec, width, height, pictures that it decoded.
std::string probed(const std::filesystem::path& film) {
  const std::filesystem::path log = film.string() + ".probe";
  EXPECT_EQ(run_program({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                         "stream=codec_name,width,height,nb_read_frames,r_frame_rate", "-of", "csv=p=0", film.string()},
                        log),
            0);
  std::ostringstream text;
  text << std::ifstream(log).rdbuf();
  return text.str();
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

TEST(Movie, OfSoilHasAPicturePerFrame) {
  if (!ffmpeg_found() || !gnuplot_found()) GTEST_SKIP() << "ffmpeg or gnuplot is not installed";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(falling), dir / "out"), exit_ok);
  const std::size_t files = files_in(dir / "out");
  movie(dir / "out", dir / "out" / "film.mp4", {.rate = 20, .width = 401});
  const std::string told = probed(dir / "out" / "film.mp4");
  EXPECT_EQ(told.rfind("h264,402,", 0), 0U) << "an odd width is made even: " << told;
  EXPECT_NE(told.find(",20/1,11\n"), std::string::npos) << "11 frames at 20 per second: " << told;
  EXPECT_EQ(files_in(dir / "out"), files + 2) << "the film and what ffprobe said: no picture is left";
  movie(dir / "out", dir / "few.webm", {.width = 320, .most = 4});
  EXPECT_EQ(probed(dir / "few.webm").rfind("vp9,320,", 0), 0U);
  EXPECT_NE(probed(dir / "few.webm").find(",25/1,4\n"), std::string::npos);
}

TEST(Movie, OfAMachineAloneIsItsStrip) {
  if (!ffmpeg_found() || !gnuplot_found()) GTEST_SKIP() << "ffmpeg or gnuplot is not installed";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(config("hoeken"), dir / "out"), exit_ok);
  movie(dir / "out", dir / "film.webm", {.width = 320, .most = 5});
  EXPECT_NE(probed(dir / "film.webm").find(",25/1,5\n"), std::string::npos);
}

TEST(Movie, RefusesWithTheCure) {
  const RunDirectory dir;
  EXPECT_EQ(message_of<std::invalid_argument>([&] { movie(dir / "out", dir / "film.avi"); }),
            "--movie: its suffix must be .mp4 or .webm, not '.avi'");
  if (ffmpeg_found()) {
    const std::string none = message_of<std::invalid_argument>([&] { movie(dir / "nothing", dir / "film.mp4"); });
    EXPECT_NE(none.find("holds no run.h5: is it the result directory of a run with frames?"), std::string::npos);
    ASSERT_EQ(run_scenario(config("1s300-modes"), dir / "modes"), exit_ok);
    const std::string still = message_of<std::invalid_argument>([&] { movie(dir / "modes", dir / "film.mp4"); });
    EXPECT_NE(still.find("has no course over time; its picture: subsoil plot "), std::string::npos) << still;
  }
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (dir / "empty").c_str(), 1);
  const std::string missing = message_of<std::runtime_error>([&] { movie(dir / "out", dir / "film.mp4"); });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(missing, "--movie: ffmpeg joins the pictures, and is not on PATH; install it: apt-get install ffmpeg");
}

}  // namespace
}  // namespace subsoil::sim::movie_test
