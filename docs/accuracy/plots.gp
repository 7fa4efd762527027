# gnuplot -e "data='FOLDER'; out='FOLDER'" plots.gp: the plots of docs/accuracy from bench/accuracy's CSV.
set datafile separator ','
set terminal svg size 640,400 font 'sans-serif,13' background '#ffffff'
set grid lc rgb '#dddddd'
set key outside right
set format y '%g%%'
array hue[6] = ['#440154', '#3b528b', '#21918c', '#5ec962', '#e69f00', '#d55e00']

set output out.'/sh_orders.svg'
set title 'Projection at records, upright pixels: error by order'
set xlabel 'order'
set ylabel 'RMS error / mean'
set logscale y
set yrange [0.1:200]
plot for [i = 2:7] data.'/sh_orders.csv' using 1:(100 * column(i)) skip 1 with linespoints \
    lc rgb hue[i - 1] pt 7 ps 0.6 title 'alpha '.word('1 0.7 0.5 0.3 0.2 0.1', i - 1), \
    1.5 dt 2 lc rgb '#888888' title '1.5%', 2.5 dt 3 lc rgb '#888888' title '2.5%', \
    5 dt 4 lc rgb '#888888' title '5%'

set output out.'/sh_tilts.svg'
set title 'Pixels tilted against their record: alpha 0.3, order 8, views of 10 and 40 degrees'
set xlabel 'tilt, degrees'
set yrange [0.5:40]
set xrange [-1:28]
# Columns: 2 + the index of the projection in allProjections().
plot data.'/sh_tilts.csv' using 1:(100 * $2) skip 1 with linespoints lc rgb hue[1] pt 7 ps 0.6 title 'zero below', \
    '' using 1:(100 * $3) skip 1 with linespoints lc rgb hue[2] pt 7 ps 0.6 title 'even reflection', \
    '' using 1:(100 * $4) skip 1 with linespoints lc rgb hue[6] pt 7 ps 0.6 title 'least squares', \
    '' using 1:(100 * $5) skip 1 with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'with a band (ours)', \
    '' using 1:(100 * $9) skip 1 with linespoints lc rgb hue[4] pt 7 ps 0.6 title 'to -15, weight 0.3', \
    '' using 1:(100 * $16) skip 1 with linespoints lc rgb hue[5] pt 7 ps 0.6 title 'hemispherical'
unset xrange

set output out.'/sh_prediction.svg'
set title 'Truncation error: predicted by the program, and measured at records'
set xlabel 'predicted'
set ylabel 'measured'
set logscale x
set format x '%g%%'
set xrange [0.03:100]
set yrange [0.03:300]
points(scene) = "< awk -F, '$1 == \"".scene."\" { print 100 * $5 \",\" 100 * $6 }' ".data.'/sh_prediction.csv'
plot x lc rgb '#888888' title 'equal', \
    points('cornell_glossy') with points pt 7 ps 0.35 lc rgb hue[2] title 'cornell\_glossy', \
    points('venus_glossy') with points pt 7 ps 0.35 lc rgb hue[6] title 'venus\_glossy', \
    points('atrium') with points pt 7 ps 0.35 lc rgb hue[3] title 'atrium'

set output out.'/hemisphere_sizes.svg'
set title 'What the hemisphere misses: irradiance by rays a record'
set xlabel 'rays a record'
set ylabel 'RMS error / mean'
set format x '%g'
set xrange [200:60000]
set yrange [1:60]
kind(name, way, extent) = "< awk -F, '$1 == \"".name."\" && $2 == \"".way."\" && $3 == ".extent." { print $5 \",\" 100 * $6 \",\" 100 * $8 }' ".data.'/hemisphere_sizes.csv'
plot kind('plane', 'middles', '3') using 1:2 with linespoints lc rgb hue[1] pt 7 ps 0.6 title 'plane, h = 3', \
    kind('larsen', 'middles', '3') using 1:2 with linespoints lc rgb hue[2] pt 7 ps 0.6 title 'larsen, h = 3', \
    kind('border', 'middles', '2') using 1:2 with linespoints lc rgb hue[4] dt 2 pt 7 ps 0.6 title 'border, h = 2', \
    kind('border', 'middles', '3') using 1:2 with linespoints lc rgb hue[4] pt 7 ps 0.6 title 'border, h = 3', \
    kind('border', 'middles', '5') using 1:2 with linespoints lc rgb hue[4] dt 3 pt 7 ps 0.6 title 'border, h = 5', \
    kind('hemicube', 'middles', '1') using 1:2 with linespoints lc rgb hue[5] pt 7 ps 0.6 title 'hemicube, middles', \
    kind('hemicube', 'random', '1') using 1:2 with linespoints lc rgb hue[6] pt 7 ps 0.6 title 'hemicube, random', \
    kind('hemicube', "the gather'\\''s", '1') using 1:2 with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'the gather'

set output out.'/hemisphere_grazing.svg'
set title 'The same for a lobe of alpha 0.3 seen at 75 degrees'
plot kind('plane', 'middles', '3') using 1:3 with linespoints lc rgb hue[1] pt 7 ps 0.6 title 'plane, h = 3', \
    kind('larsen', 'middles', '3') using 1:3 with linespoints lc rgb hue[2] pt 7 ps 0.6 title 'larsen, h = 3', \
    kind('border', 'middles', '2') using 1:3 with linespoints lc rgb hue[4] dt 2 pt 7 ps 0.6 title 'border, h = 2', \
    kind('border', 'middles', '3') using 1:3 with linespoints lc rgb hue[4] pt 7 ps 0.6 title 'border, h = 3', \
    kind('border', 'middles', '5') using 1:3 with linespoints lc rgb hue[4] dt 3 pt 7 ps 0.6 title 'border, h = 5', \
    kind('hemicube', 'middles', '1') using 1:3 with linespoints lc rgb hue[5] pt 7 ps 0.6 title 'hemicube, middles', \
    kind('hemicube', 'random', '1') using 1:3 with linespoints lc rgb hue[6] pt 7 ps 0.6 title 'hemicube, random'

set output out.'/gradients_moved.svg'
set title 'A quarter of R away from the record, alpha 0.3: what gradients of n bands leave'
set xlabel 'bands with a gradient'
unset logscale x
unset logscale y
set xrange [-0.3:6.3]
set yrange [0:*]
# The columns of all places: the last four.
plot data.'/gradients_moved.csv' using 1:(100 * $14) skip 1 with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'first bands (ours)', \
    '' using 1:(100 * $15) skip 1 with linespoints lc rgb hue[6] lw 2 pt 7 ps 0.6 title 'fitted alone', \
    '' using 1:(100 * $16) skip 1 with linespoints lc rgb 'black' dt 3 pt 6 ps 0.6 title 'true, first bands', \
    '' using 1:(100 * $17) skip 1 with linespoints lc rgb hue[6] dt 3 pt 6 ps 0.6 title 'true, fitted alone'
