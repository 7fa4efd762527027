# data: sh_prediction.csv
set title 'Truncation at orders 4, 6, 8, 10: predicted by the program, and measured'
set xlabel 'predicted'
set ylabel 'measured: RMS error / mean'
set logscale xy
set format x '%g%%'
set xrange [0.03:100]
set yrange [0.03:300]
points(scene) = "< awk -F, '$1 == \"".scene."\" && $4 % 2 == 0 { print 100 * $5 \",\" 100 * $6 }' ".data.'/sh_prediction.csv'
plot x lc rgb '#888888' title 'equal', \
    points('cornell_glossy') with points pt 7 ps 0.35 lc rgb hue[2] title 'cornell\_glossy', \
    points('venus_glossy') with points pt 7 ps 0.35 lc rgb hue[6] title 'venus\_glossy', \
    points('atrium') with points pt 7 ps 0.35 lc rgb hue[3] title 'atrium'
