#include "tests/tools/browser.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "libsim/post/frames_file.hpp"
#include "libsim/report/report.hpp"
#include "libsim/view/show.hpp"
#include "libsim/view/view.hpp"
#include "tests/tools/program_runs.hpp"

/// Pages opened in headless Chromium (scripts/setup --browser): a report and the pictures of `show` and `view` draw
/// themselves without an error, and show what scenario and series say. Left out where there is no Chromium.
namespace subsoil::sim::browser_test {
namespace {

TEST(Browser, ReportDrawsItselfAndShowsValues) {
  if (!test::has_browser()) GTEST_SKIP() << "no chromium: scripts/setup --browser";
  const test::RunDirectory directory;
  ASSERT_EQ(test::run_scenario(directory.scenario(test::small_pass), directory / "run"), exit_ok);
  ReportRequest request;
  request.runs = {directory / "run"};
  request.out = directory / "page.html";
  write_report(request);
  const std::string dom = test::opened(request.out, "#probe=draft@0.1", directory);
  EXPECT_NE(dom.find("data-ready=\"yes\""), std::string::npos) << dom.substr(0, 2000);
  EXPECT_NE(dom.find("data-errors=\"0\""), std::string::npos);
  EXPECT_EQ(test::console_of(dom), "");
  // The cursor sits on a row near 0.1 s: its time and value stand in the page and in the series alike.
  const std::size_t at = dom.find("data-probe=\"");
  ASSERT_NE(at, std::string::npos);
  double time = 0, value = 0;
  ASSERT_EQ(std::sscanf(dom.c_str() + at, "data-probe=\"%lf s | %lf N", &time, &value), 2) << dom.substr(at, 80);
  EXPECT_NEAR(time, 0.1, 2e-3);
  const Series series = read_series(directory / "run" / "series.csv");
  const std::vector<double>& t = series.at("time");
  double nearest = 1, expected = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (std::abs(t[i] - time) < nearest) nearest = std::abs(t[i] - time), expected = series.at("draft")[i];
  EXPECT_NEAR(value, expected, 1e-4 * std::abs(expected) + 1e-6) << "five digits are shown";
}

/// Film, still frames and slices of two runs: all at one time, none of one colour, and the films' own cameras stay.
TEST(Browser, ReportShowsFilmAndStillFrames) {
  if (!test::has_browser()) GTEST_SKIP() << "no chromium: scripts/setup --browser";
  const test::RunDirectory directory;
  ASSERT_EQ(test::run_scenario(directory.scenario(test::small_pass), directory / "run"), exit_ok);
  ReportRequest request;
  request.runs = {directory / "run", directory / "run"};
  request.out = directory / "page.html";
  write_report(request);
  const nlohmann::json found = test::asked(request.out, R"(
    const viewers = [...document.querySelectorAll('iframe.film')].map(f => f.contentWindow.subsoil);
    const camera = viewers[0].stage.camera.position.toArray();
    viewers[1].show(0.05);
    const colours = async image => {
      await image.decode();
      const canvas = document.createElement('canvas'), c = canvas.getContext('2d');
      canvas.width = image.naturalWidth, canvas.height = image.naturalHeight;
      c.drawImage(image, 0, 0);
      return new Set(new Uint32Array(c.getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size;
    };
    const stills = await Promise.all([...document.querySelectorAll('#stills img')].map(colours));
    const slices = await Promise.all([...document.querySelectorAll('#section img')].map(colours));
    viewers[0].still({ time: 0.1, width: 300, height: 200, chains: true, section: { axis: 2, at: 0, sign: 1 } });
    return { films: viewers.length, times: viewers.map(v => v.time), stills, slices, moved: Math.hypot(...viewers[0].stage.camera.position.toArray().map((v, i) => v - camera[i])),
             chains: viewers[0].soil.chains.mesh.visible, section: viewers[0].stage.section, errors: viewers.flatMap(v => v.errors),
             reds: viewers[0].soil.now.chains.length / 7 };
  )",
                                           directory);
  const std::size_t stills = report_data(request)["runs"][0]["stills"].size();
  EXPECT_GE(stills, 3U);
  EXPECT_EQ(found["films"], 2);
  EXPECT_EQ(found["times"], nlohmann::json({0.05, 0.05}));
  ASSERT_EQ(found["stills"].size(), 2 * stills);
  ASSERT_EQ(found["slices"].size(), 6U) << "speed, chains and depth of each run";
  // Cut spheres at rest have one shade, besides background, edges and the container's frame.
  for (const nlohmann::json& colours : found["stills"]) EXPECT_GT(colours, 4);
  EXPECT_GT(found["stills"].back(), 50) << "spheres at many speeds, and the tool";
  for (const nlohmann::json& colours : found["slices"]) EXPECT_GT(colours, 50);
  EXPECT_EQ(found["moved"], 0);
  EXPECT_EQ(found["chains"], false);
  EXPECT_TRUE(found["section"].is_null());
  EXPECT_TRUE(found["errors"].empty()) << found["errors"];
  EXPECT_GT(found["reds"], 10);
}

/// Share of the stage's pixels that are not the background.
constexpr const char* drawn_share = R"(
  const share = () => {
    viewer.stage.drawNow();
    const gl = viewer.stage.renderer.getContext(), w = viewer.stage.canvas.width, h = viewer.stage.canvas.height;
    const pixels = new Uint8Array(4 * w * h);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let drawn = 0;
    for (let i = 0; i < pixels.length; i += 4)
      drawn += Math.abs(pixels[i] - pixels[0]) + Math.abs(pixels[i + 1] - pixels[1]) + Math.abs(pixels[i + 2] - pixels[2]) > 12;
    return drawn / (w * h);
  };
)";

/// A block on a rail, a slab beside it and a tall tine on a given path: places that a test can work out by hand.
constexpr const char* three_boxes = R"(subsoil: 1
title: three boxes
materials: {steel: {density: 7850 kg/m^3}}
contacts: [{between: [steel, steel], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5, mu_r: 0.1}]
machine:
  bodies:
    block: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m}
    slab: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.5 0 m}
  joints:
    rail: {translational: [ground, block], along: 1 0}
    weld: {fixed: [ground, slab], at: 0.5 0 m}
  drivers: {push: {coordinate: block.x, velocity: 0.2 m/s}}
  surfaces:
    cube: {body: block, material: steel, box: 100 100 100 mm}
    plate: {body: slab, material: steel, box: 200 20 100 mm}
boundaries:
  - {name: tine, material: steel, shape: {box: 20 300 20 mm}, at: -0.4 0 0 m, moves: [{velocity: 0 0.1 0 m/s}]}
time: {end: 1 s}
output: {monitor: {force: {driver: push}}}
)";

class Shown : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::has_browser()) GTEST_SKIP() << "no chromium: scripts/setup --browser";
    ShowRequest request;
    request.scenario = directory.scenario(three_boxes);
    request.out = page = directory / "show.html";
    write_show(request);
  }
  nlohmann::json asked(const std::string& script) const { return test::asked(page, script, directory); }
  test::RunDirectory directory;
  std::filesystem::path page;
};

TEST_F(Shown, PixelsAreNotEmptyAndPickingFindsWhatIsThere) {
  const nlohmann::json found = asked(std::string(drawn_share) + R"(
    viewer.stage.look('side');
    const drawn = share(), hit = (x, y) => {
      const p = viewer.stage.project(new THREE.Vector3(x, y, 0)), picked = viewer.pick(p[0], p[1]);
      return picked && picked.thing >= 0 ? viewer.scene.things[picked.thing].name : null;
    };
    return { drawn, cube: hit(0.02, 0.03), plate: hit(0.58, 0.005), tine: hit(-0.4, 0.12), nothing: hit(0.2, 0.13),
             words: (hit(0.02, 0.03), document.querySelector('.details').textContent) };
  )");
  // Side view: the boxes cover 0.01 + 0.004 + 0.006 m2 of the 1.01 m x 0.3 m around them, which fill most of the width.
  EXPECT_GT(found["drawn"], 0.01);
  EXPECT_LT(found["drawn"], 0.5);
  EXPECT_EQ(found["cube"], "cube");
  EXPECT_EQ(found["plate"], "plate");
  EXPECT_EQ(found["tine"], "tine");
  EXPECT_TRUE(found["nothing"].is_null());
  EXPECT_NE(found["words"].get<std::string>().find("case.yaml:14:"), std::string::npos) << found["words"];
}

TEST_F(Shown, TheSliderMovesBodiesAndPathsAsTheScenarioSays) {
  const nlohmann::json found = asked(R"(
    const slider = document.getElementById('time');
    slider.value = '0.5';
    slider.dispatchEvent(new Event('input'));
    const of = name => viewer.machine.pickable.find(m => viewer.scene.things[m.userData.thing].name === name);
    const at = name => new THREE.Vector3().setFromMatrixPosition(of(name).matrixWorld).toArray();
    return { block: at('cube'), tine: at('tine') };
  )");
  EXPECT_NEAR(found["block"][0].get<double>(), 0.1, 1e-6) << "0.2 m/s for half a second";
  EXPECT_NEAR(found["tine"][0].get<double>(), -0.4, 1e-6);
  EXPECT_NEAR(found["tine"][1].get<double>(), 0.05, 1e-6);
}

TEST_F(Shown, ASectionPlaneCutsAwayWhatLiesBeyond) {
  const nlohmann::json found = asked(std::string(drawn_share) + R"(
    viewer.stage.look('side');
    const whole = share();
    viewer.stage.cut({ axis: 0, at: -0.2, sign: 1 });
    const left = share(), p = viewer.stage.project(new THREE.Vector3(0.02, 0.03, 0));
    return { whole, left, cut: viewer.pick(p[0], p[1]) };
  )");
  EXPECT_LT(found["left"].get<double>(), 0.6 * found["whole"].get<double>()) << "two of three boxes are gone";
  EXPECT_GT(found["left"], 0);
  EXPECT_TRUE(found["cut"].is_null());
}

TEST_F(Shown, KeysChooseViewsAndEveryControlHasAName) {
  const nlohmann::json found = asked(R"(
    const press = key => document.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    const facing = () => viewer.stage.camera.getWorldDirection(new THREE.Vector3()).toArray();
    press('2');
    const side = facing();
    press('4');
    const top = facing();
    press(' ');
    const playing = viewer.playing;
    press(' ');
    const named = e => (e.getAttribute('aria-label') || e.textContent || (e.labels && e.labels[0] && e.labels[0].textContent) || '').trim();
    const nameless = [...document.querySelectorAll('button, select, input, canvas, svg.overlay')].filter(e => !named(e)).map(e => e.outerHTML);
    return { side, top, playing, stopped: !viewer.playing, nameless, symbols: document.querySelectorAll('.overlay .thing[aria-label]').length };
  )");
  EXPECT_NEAR(found["side"][2].get<double>(), -1, 1e-9);
  EXPECT_NEAR(found["top"][1].get<double>(), -1, 1e-9);
  EXPECT_TRUE(found["playing"]);
  EXPECT_TRUE(found["stopped"]);
  EXPECT_TRUE(found["nameless"].empty()) << found["nameless"];
  EXPECT_GT(found["symbols"], 3);
}

TEST_F(Shown, AWarningStandsAtWhatItMeans) {
  const nlohmann::json found = asked(R"(
    viewer.scene.warnings.push({ text: 'of the tine', things: [viewer.scene.things.findIndex(t => t.name === 'tine')] });
    viewer.stage.look('side');
    viewer.show(1);
    viewer.stage.drawNow();
    const marks = [...document.querySelectorAll('[data-warning]')], mark = marks[marks.length - 1];
    const start = mark.querySelector('path').getAttribute('d').match(/^M([-\d.]+) ([-\d.]+)/).slice(1).map(Number);
    const tine = viewer.stage.project(new THREE.Vector3(-0.4, 0.1, 0));
    return { count: marks.length, off: Math.hypot(start[0] - tine[0], start[1] - tine[1]), label: mark.getAttribute('aria-label') };
  )");
  EXPECT_GE(found["count"], 1);
  EXPECT_LT(found["off"], 1.0) << "pixels";
  EXPECT_NE(found["label"].get<std::string>().find("tine"), std::string::npos);
}

TEST_F(Shown, AllOfTheSceneIsInThePictureWhateverItsSize) {
  const nlohmann::json found = asked(R"(
    const holder = viewer.stage.parent, out = [];
    for (const width of [500, 1300]) {
      holder.style.flex = `0 0 ${width}px`;
      viewer.stage.look('side');
      holder.style.flex = `0 0 ${0.6 * width}px`;
      viewer.stage.resize();
      for (const x of [-0.41, 0.6]) out.push(viewer.stage.project(new THREE.Vector3(x, 0, 0))[0] / viewer.stage.width);
    }
    return out;
  )");
  for (const nlohmann::json& share : found) {
    EXPECT_GT(share, 0);
    EXPECT_LT(share, 1);
  }
}

TEST(Viewed, SliderSpheresAndArrowsAreThoseOfTheSeries) {
  if (!test::has_browser()) GTEST_SKIP() << "no chromium: scripts/setup --browser";
  const test::RunDirectory directory;
  ASSERT_EQ(test::run_scenario(directory.scenario(test::small_pass), directory / "run"), exit_ok);
  ViewRequest request;
  request.run = directory / "run";
  request.out = directory / "view.html";
  write_view(request);
  const Series series = read_series(directory / "run" / "series.csv");
  const std::size_t row = series.rows() - 20;
  const double time = series.at("time")[row];
  const nlohmann::json found =
      test::asked(request.out, std::string(drawn_share) + "const time = " + std::to_string(time) + R"(;
    viewer.stage.look('side');
    const drawn = share();
    viewer.colour('speed');
    viewer.show(time);
    viewer.stage.drawNow();
    const blade = viewer.machine.pickable.find(m => viewer.scene.things[m.userData.thing].name === 'blade');
    const arrow = document.querySelector('[data-force="soil on tine"]');
    const numbers = key => arrow.getAttribute(key).split(' ').map(Number);
    const size = () => viewer.soil.extent().getSize(new THREE.Vector3()).length(), rest = size(), p0 = viewer.soil.now.positions[0];
    viewer.soil.now.positions[0] = 65534;
    const flown = size();
    viewer.soil.now.positions[0] = p0;
    viewer.machine.root.visible = false;
    const sphere = viewer.soil.at(7), p = viewer.stage.project(sphere);
    viewer.stage.cut({ axis: 2, at: sphere.z + 1e-4, sign: 1 });
    return { drawn, rest, flown, blade: new THREE.Vector3().setFromMatrixPosition(blade.matrixWorld).toArray(), from: numbers('data-from'),
             to: numbers('data-to'), colours: viewer.soil.colourings(), count: viewer.soil.data.count, clock: viewer.clock.textContent };
  )",
                  directory);
  EXPECT_GT(found["drawn"], 0.05);
  EXPECT_NEAR(found["flown"].get<double>() / found["rest"].get<double>(), 1, 0.1) << "one sphere of 224 does not count";
  // The page's times are of six digits here, the poses of float.
  EXPECT_NEAR(found["blade"][0].get<double>(), series.at("tine.x")[row], 1e-6);
  EXPECT_NEAR(found["blade"][1].get<double>(), series.at("tine.y")[row], 1e-6);
  const double fx = series.at("tine.soil.Fx")[row], fy = series.at("tine.soil.Fy")[row], size = std::hypot(fx, fy);
  ASSERT_GT(size, 1) << "the tine is in the soil";
  const double dx = found["to"][0].get<double>() - found["from"][0].get<double>(),
               dy = found["from"][1].get<double>() - found["to"][1].get<double>(), length = std::hypot(dx, dy);
  EXPECT_GT((dx * fx + dy * fy) / (length * size), 0.9999) << "the arrow lies along the force";
  EXPECT_EQ(found["clock"].get<std::string>().substr(0, 5), std::to_string(time).substr(0, 5));
}

double number_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  return at == std::string::npos ? -1 : std::strtod(text.c_str() + at + word.size(), nullptr);
}

/// `run --view`: the page that is open takes over what the run writes, and its slider stays at the newest instant.
TEST(Followed, TheNewestFrameOfARunInProgressIsShown) {
  if (!test::has_browser()) GTEST_SKIP() << "no chromium: scripts/setup --browser";
  const test::RunDirectory directory;
  const std::filesystem::path scenario = directory.scenario(test::small_pass), words = directory / "words";
  const std::string pid = test::output_of(
      "cd " + directory.path().string() + " && { setsid " + subsoil::test::program() + " run " + scenario.string() +
      " --out run --view --set time.end=1e4s --set 'machine.drivers.tow.velocity=0 m/s' --set "
      "'output.every=200 ms' > words 2>&1 & echo $!; }");
  std::string address;
  for (int i = 0; i < 600 && address.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const std::string text = std::filesystem::exists(words) ? test::text_of(words) : "";
    const std::size_t at = text.find("http://"), end = text.find_first_of(" \n", at);
    if (at != std::string::npos && end != std::string::npos) address = text.substr(at, end - at);
  }
  // Loaded with the first frames; each look that finds something new is counted by the page.
  const auto frames = [&] {
    try {
      return FramesFile((directory / "run" / "run.h5").string()).times().size();
    } catch (const std::exception&) {
      return std::size_t{0};  // not begun
    }
  };
  for (int i = 0; i < 600 && frames() < 3; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::size_t before = frames();
  // On a loaded machine the run may write nothing while the page is open, which takes some seconds: opened again.
  std::string dom;
  double newest = -1;
  for (int i = 0; i < 5 && !address.empty() && !(newest > 0.2 * static_cast<double>(before - 1)); ++i)
    dom = test::opened_at(address, directory), newest = number_after(dom, " max=\"");
  test::output_of("kill -- -" + pid.substr(0, pid.find('\n')) + " 2>&1");
  ASSERT_FALSE(address.empty()) << test::text_of(words);
  EXPECT_EQ(test::console_of(dom), "");
  EXPECT_NE(dom.find("data-errors=\"0\""), std::string::npos) << dom.substr(0, 500);
  EXPECT_GE(number_after(dom, "data-renewed=\""), 2) << dom.substr(0, 500);
  EXPECT_NE(dom.find("running: "), std::string::npos) << "progress and time left";
  const double frame = number_after(dom, "data-frame=\"");
  EXPECT_GT(newest, 0.2 * static_cast<double>(before - 1))
      << "the slider reaches rows that were written after the start";
  EXPECT_GE(frame, before - 1) << "and the spheres are those of the newest frame";
}

}  // namespace
}  // namespace subsoil::sim::browser_test
