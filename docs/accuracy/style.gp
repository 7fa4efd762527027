# What all plots share; data: folder of the CSV files, out: the SVG file.
set datafile separator ','
set terminal svg size 640,400 font 'sans-serif,13' background '#ffffff'
set output out
set grid lc rgb '#dddddd'
set key outside right
set format y '%g%%'
array hue[6] = ['#440154', '#3b528b', '#21918c', '#5ec962', '#e69f00', '#d55e00']
