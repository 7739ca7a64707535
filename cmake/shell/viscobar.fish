# fish completion of viscobar, which is asked for its commands, options and keys
function __viscobar_options
    viscobar help (commandline -opc)[2..2] | string match -rg '^ +(?:-\w, *)?(--[a-z-]+)'
end
complete -c viscobar -f
complete -c viscobar -n __fish_use_subcommand -a "(viscobar help | string match -rg '^ +([a-z]+)  ')"
complete -c viscobar -n 'not __fish_use_subcommand' -a '(__viscobar_options)'
complete -c viscobar -n 'not __fish_use_subcommand' -k -a '(__fish_complete_suffix .toml; __fish_complete_directories)'
complete -c viscobar -n '__fish_prev_arg_in --set' -a "(viscobar list keys | string match -rg '^ +([a-zA-Z_.]+) *\$')="
