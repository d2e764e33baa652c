# Pictures of docs/verification/index.md: scripts/verify calls this with `curves` (a folder of .dat files) and `pictures`.
# Points of the paper: Kratos Multiphysics, DEMApplication, basic_benchmarks/paper_data.
set terminal pngcairo size 1200,420 font "sans,10" linewidth 1.3
set grid lc rgb "#dddddd"
set tics nomirror
set border 3
dat(name) = curves."/".name.".dat"
ours = "#1f5fa8"; other = "#c0392b"; third = "#7f8c8d"

$e_t << EOD
5.168 .9481
10.158 .6870
14.990 .6244
20.059 .6161
25.050 .6343
30.119 .6837
35.030 .7372
40.020 .7809
50 .8451
59.980 .8929
69.960 .9316
80.020 .9662
85.010 .9827
EOD
$omega << EOD
4.951 -19.27
10.079 -213.0
14.970 -377.8
19.941 -510.6
24.911 -599.4
29.961 -616.5
34.931 -582.3
39.980 -544.8
50 -457.0
60.020 -357.5
69.961 -246.2
80.059 -126.3
85.030 -63.1
EOD
$rebound << EOD
4.901 3.76
9.959 -1.56
14.935 -5.54
19.988 -7.54
24.958 -7.54
29.922 -3.55
34.962 3.43
39.920 11.57
49.834 29.35
59.987 47.79
69.742 64.58
79.822 78.70
84.783 84.52
EOD
$measured << EOD
2.238 .7965
4.218 .7463
9.842 .6755
20.218 .5988
30.356 .6903
39.545 .7743
49.604 .8476
71.069 .9366
79.228 .9695
85.168 .9794
EOD
set output pictures."/verify-chung-ooi-4.png"
set multiplot layout 1,3 title "Chung and Ooi 4: aluminium oxide on a rigid wall, 3.9 m/s, e 0.98, {/Symbol m} 0.092"
set xlabel "angle of impact from the normal (deg)"
set xrange [0:90]
set key bottom right
set ylabel "tangential restitution"
set yrange [0.4:1]
plot dat("chung-ooi-4") using 1:2 with lines lc rgb ours title "subsoil, lossy", \
     dat("chung-ooi-4") using 1:5 with lines dt 2 lc rgb ours title "subsoil, keep-spring", $e_t with points pt 6 lc rgb other title "paper, DEM", \
     $measured with points pt 2 lc rgb third title "paper, measured (Kharaz et al.)"
set ylabel "angular velocity (rad/s)"
set yrange [*:0]
set key top center
plot dat("chung-ooi-4") using 1:3 with lines lc rgb ours title "subsoil, lossy", \
     dat("chung-ooi-4") using 1:6 with lines dt 2 lc rgb ours title "subsoil, keep-spring", $omega with points pt 6 lc rgb other title "paper, DEM"
set ylabel "rebound angle of the contact point (deg)"
set yrange [-20:90]
set key top left
plot dat("chung-ooi-4") using 1:4 with lines lc rgb ours title "subsoil, lossy", \
     dat("chung-ooi-4") using 1:7 with lines dt 2 lc rgb ours title "subsoil, keep-spring", $rebound with points pt 6 lc rgb other title "paper, DEM"
unset multiplot

$psi2 << EOD
.0665 -.08
.332 -.28
.671 -.493
1.009 -.747
1.335 -1
1.662 -1.267
2 -1.533
2.350 -1.813
2.991 -2.44
3.341 -2.693
4.006 -2.787
4.997 -2
6 -1.013
9.988 3.013
12.961 6.013
EOD
$psi2fem << EOD
.272 -.027
.586 -.027
.876 -.08
1.190 -.213
1.553 -.373
1.915 -.627
2.314 -.947
2.785 -1.253
3.317 -1.52
3.970 -1.72
4.755 -1.707
5.758 -1.2
7.124 .133
9.118 2.147
12.356 5.427
EOD
$spin << EOD
.058 -.106
.353 -.430
.682 -.820
.994 -1.250
1.341 -1.664
1.688 -2.094
2 -2.524
2.329 -2.978
2.988 -3.904
3.318 -4.293
3.994 -4.837
5 -5.007
6.006 -5.006
10.012 -5.004
EOD
$spinfem << EOD
.318 -.187
.595 -.406
.890 -.665
1.185 -.982
1.532 -1.355
1.896 -1.793
2.277 -2.321
2.763 -2.856
3.301 -3.441
3.890 -4.041
4.688 -4.569
5.659 -4.941
7.029 -4.941
9.040 -4.972
EOD
set terminal pngcairo size 1000,420 font "sans,10" linewidth 1.3
set output pictures."/verify-chung-ooi-5.png"
set multiplot layout 1,2 title "Chung and Ooi 5: steel, constant normal velocity"
set xrange [0:10]
set xlabel "{/Symbol y}_1 = V_{st}/({/Symbol m} V_{cn})"
set ylabel "{/Symbol y}_2, contact point after"
set yrange [-3.2:3.5]
set key top left
plot dat("chung-ooi-5-steel") using 1:2 with lines lc rgb ours title "subsoil, G* of two equal bodies, keep-force", \
     dat("chung-ooi-5-steel") using 1:4 with lines dt 2 lc rgb ours title "subsoil, G* of the rigid wall", \
     $psi2 with points pt 6 lc rgb other title "paper, DEM", $psi2fem with points pt 2 lc rgb third title "paper, finite elements"
set ylabel "R {/Symbol w}/({/Symbol m} V_n)"
set yrange [-5.5:0]
set key top right
plot dat("chung-ooi-5-steel") using 1:3 with lines lc rgb ours title "subsoil, G* of two equal bodies, keep-force", \
     dat("chung-ooi-5-steel") using 1:5 with lines dt 2 lc rgb ours title "subsoil, G* of the rigid wall", \
     $spin with points pt 6 lc rgb other title "paper, DEM", $spinfem with points pt 2 lc rgb third title "paper, finite elements"
unset multiplot

set terminal pngcairo size 1200,420 font "sans,10" linewidth 1.3
set output pictures."/verify-pulls.png"
set multiplot layout 1,3 title "Force over the distance of the surfaces (pull positive)"
set xrange [*:*]
set yrange [*:*]
set key top right
set xlabel "distance ({/Symbol m}m)"
set ylabel "pull (mN)"
set yrange [-0.3:5]
jkr = 1.5*pi*0.4*2e-3*1e3
set title "JKR, sphere of 2 mm off a plane"
plot dat("pull-jkr") using ($1*1e6):($2*1e3) with lines lc rgb ours title "subsoil", jkr with lines dt 2 lc rgb other title "1.5 {/Symbol p} w R"
set yrange [-20:340]
set title "DMT on a linear spring"
dmt = 2*pi*20*2e-3*1e3
plot dat("pull-dmt") using ($1*1e6):($2*1e3) with lines lc rgb ours title "subsoil", dmt with lines dt 2 lc rgb other title "2 {/Symbol p} w R"
set yrange [0:*]
set title "bridge of water between two spheres of 2 mm"
plot dat("bridge-3") using ($1*1e6):($2*1e3) with lines lc rgb ours title "subsoil, V = 10^{-3} r^3", \
     dat("bridge-3") using ($1*1e6):($3*1e3) with lines dt 2 lc rgb ours title "Willett's fit", \
     dat("bridge-2") using ($1*1e6):($2*1e3) with lines lc rgb other title "subsoil, V = 10^{-2} r^3", \
     dat("bridge-2") using ($1*1e6):($3*1e3) with lines dt 2 lc rgb other title "Willett's fit"
unset multiplot

set terminal pngcairo size 1000,640 font "sans,10" linewidth 1.3
set output pictures."/verify-loops.png"
set multiplot layout 2,2 title "Loading and unloading to 1 mm (line) and corners by hand (points)"
set xlabel "overlap (mm)"
set ylabel "force (N)"
set xrange [0:1.05]
set key top left
$hysteretic << EOD
1 10
0.9 6
0.75 0
EOD
tear = 10000.0*26000/(26000.0+10000)*0 + (26000.0-10000)/(26000.0+10000)
array luding[6] = [1, 10, 1-10.0/26, 0, tear, -10*tear]
set title "hysteretic spring"
plot dat("loop-hysteretic") using ($1*1e3):2 with lines lc rgb ours notitle, $hysteretic with points pt 7 lc rgb other notitle
set title "Luding"
plot dat("loop-luding") using ($1*1e3):2 with lines lc rgb ours notitle, \
     '+' using (luding[2*int($0)+1]):(luding[2*int($0)+2]) every ::0::2 with points pt 7 lc rgb other notitle
k2 = 1e4/0.4; top = 0.6e-3; a = 1.5*pi*20*sqrt(2*5e-3*top); corner = top - a/k2
set title "EEPA, n = 1"
$none << EOD
0
EOD
plot dat("loop-eepa-1") using ($1*1e3):2 with lines lc rgb ours notitle, \
     $none using (1):(10) with points pt 7 lc rgb other notitle, $none using (top*1e3):(0) with points pt 7 lc rgb other notitle, \
     $none using (corner*1e3):(-a) with points pt 7 lc rgb other notitle
res = 0.6**(2.0/3)*1e-3; b = 1.5*pi*20*sqrt(2*5e-3*res); kk = 3e5/0.4; cor = (0.6*1e-3**1.5 - b/kk)**(2.0/3)
set title "EEPA, n = 3/2"
plot dat("loop-eepa-1.5") using ($1*1e3):2 with lines lc rgb ours notitle, \
     $none using (1):(3e5*1e-3**1.5) with points pt 7 lc rgb other notitle, $none using (res*1e3):(0) with points pt 7 lc rgb other notitle, \
     $none using (cor*1e3):(-b) with points pt 7 lc rgb other notitle
unset multiplot
