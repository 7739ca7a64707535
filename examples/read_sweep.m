% Reads the files of a result of `viscobar sweep`: octave read_sweep.m DIR. The rows are those of sweep.h5, digit by digit.
result = argv(){1};
sweep = jsondecode(fileread(fullfile(result, "sweep.json")));
file = fopen(fullfile(result, "sweep.csv"));
names = strsplit(fgetl(file), ",");
rows = textscan(file, repmat("%q", 1, numel(names)), "Delimiter", ",");    % a cell of texts for each column
column = @(name) str2double(rows{strcmp(names, name)});
seconds = dlmread(fullfile(result, "timings.csv"), ",", 1, 1)(:, 1);
printf("%s in %g seconds of %d cases\n", sweep.title, sum(seconds), numel(seconds));
printf("failed: %d largest penetration = %.15g\n", sum(column("completed") == 0), max(column("max_penetration")));
